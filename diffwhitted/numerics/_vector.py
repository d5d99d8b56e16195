"""Three-component vectors as three separate arrays, and look-ups in small tables.

A reduction over an axis of length three is slow on XLA's CPU back end, so a vector is never an
array of shape (n, 3) inside the renderer: it is a `Vec3` of three arrays of one shape, and every
product is written out. The same type carries directions, points and linear RGB colours.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

SMALL_TABLE = 8


class Vec3(eqx.Module):
    """A vector (or linear RGB colour) whose components are arrays of one common shape."""

    x: Float[Array, "*n"]
    y: Float[Array, "*n"]
    z: Float[Array, "*n"]

    def __add__(self, other: "Vec3") -> "Vec3":
        return Vec3(self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: "Vec3") -> "Vec3":
        return Vec3(self.x - other.x, self.y - other.y, self.z - other.z)

    def __neg__(self) -> "Vec3":
        return Vec3(-self.x, -self.y, -self.z)

    def __mul__(self, other) -> "Vec3":
        """Scale by an array, or multiply component by component (colours)."""
        if isinstance(other, Vec3):
            return Vec3(self.x * other.x, self.y * other.y, self.z * other.z)
        return Vec3(self.x * other, self.y * other, self.z * other)

    __rmul__ = __mul__

    @property
    def shape(self) -> tuple[int, ...]:
        return jnp.shape(self.x)

    @property
    def dtype(self):
        return self.x.dtype

    def stacked(self, axis: int = -1) -> Float[Array, "..."]:
        """The components as one array, (*n, 3) where `axis` is the last, for the world outside the renderer."""
        return jnp.stack([self.x, self.y, self.z], axis=axis)


def vec3(array: Float[Array, "*n 3"]) -> Vec3:
    """Split an array whose last axis has length three."""
    return Vec3(array[..., 0], array[..., 1], array[..., 2])


def dot(a: Vec3, b: Vec3) -> Float[Array, "*n"]:
    return a.x * b.x + a.y * b.y + a.z * b.z


def brightest(colour: Vec3) -> Float[Array, "*n"]:
    """The largest of the three channels."""
    return jnp.maximum(jnp.maximum(colour.x, colour.y), colour.z)


def cross(a: Vec3, b: Vec3) -> Vec3:
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


def tangents(normal: Vec3) -> tuple[Vec3, Vec3]:
    """Two unit vectors at right angles to a unit normal and to each other, right-handed with it (Duff et al. 2017).

    Edge: where normal.z changes its sign they turn about it in a jump; of a zero normal they are x and y.
    """
    sign = jnp.where(normal.z < 0, -1.0, 1.0).astype(normal.dtype)
    a = -1 / (sign + normal.z)
    b = normal.x * normal.y * a
    return (
        Vec3(1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vec3(b, sign + normal.y * normal.y * a, -normal.y),
    )


def where(condition, a, b):
    """`jnp.where` over two pytrees of the same structure."""
    return jax.tree.map(lambda p, q: jnp.where(condition, p, q), a, b)


def lookup(table, index: Int[Array, "*n"]):
    """Row `index` of every array in `table` (leading axis: the rows).

    A table of at most eight rows is read by a chain of selections, which runs in vector
    registers; a longer one by a gather.
    """
    return jax.tree.map(lambda column: _lookup_column(column, index), table)


def _lookup_column(column, index):
    rows = column.shape[0]
    if rows == 0:
        return jnp.zeros(jnp.shape(index), column.dtype)
    if rows > SMALL_TABLE or column.ndim > 1:
        return jnp.take(column, index, axis=0, mode="clip")
    return _selected(column, index)


@jax.custom_jvp
def _selected(column, index):
    value = jnp.broadcast_to(column[0], jnp.shape(index))
    for row in range(1, column.shape[0]):
        value = jnp.where(index == row, column[row], value)
    return value


@_selected.defjvp
def _selected_jvp(primals, tangents):
    """A product with a matrix of zeros and ones, whose transpose XLA sums in vector registers."""
    column, index = primals
    wanted = jnp.clip(index, 0).ravel() == jnp.arange(column.shape[0])[:, None]
    along = jnp.matmul(tangents[0], wanted.astype(column.dtype), precision="highest")
    return _selected(column, index), along.reshape(jnp.shape(index))
