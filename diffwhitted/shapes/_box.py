"""Boxes, and what transforms make of them."""

from collections.abc import Sequence
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import AbstractSurfaces, Ray
from ..numerics._safe import normalise, safe_divide
from ..numerics._vector import Vec3, cross, dot, vec3, where
from ..records import Row, changed, is_traced, listed, read_rows, stacked
from ._implicit import ahead, closest, finite
from ._object import AbstractObject


class Boxes(AbstractSurfaces):
    """Bodies between three pairs of parallel planes: |across_k.(x - middle)| <= 1."""

    SOLID: ClassVar[bool] = True

    middle: Vec3
    across: tuple[Vec3, Vec3, Vec3]
    """Square to the faces; as long as one over the distance of a face from the middle."""
    radius: Float[Array, "*n"]
    """Of the bounding sphere."""

    def crossings(self, ray: Ray, on_it, inwards):
        """Where the ray enters and where it leaves: the last plane that it enters by, the first that it leaves by."""
        along, enters, leaves, met = self._interval(ray)
        return ahead(along + enters[0], along + leaves[0], met, on_it, inwards)

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point of the face that the crossing is on, differentiable."""
        along, enters, leaves, _ = jax.lax.stop_gradient(self._interval(ray))
        entering = crossing == 0
        _, face = where(entering, enters, leaves)
        across = where(face == 0, self.across[0], where(face == 1, self.across[1], self.across[2]))
        along, at = closest(ray, self.middle)
        towards = dot(across, ray.direction)
        side = jnp.where((jax.lax.stop_gradient(towards) > 0) == entering, -1, 1).astype(along.dtype)
        reach = safe_divide(side - dot(across, at), towards)
        at = at + ray.direction * reach
        return along + reach, normalise(across) * side, self.middle + at, entering

    def contains(self, point: Vec3):
        at = point - self.middle
        first, second, third = (abs(dot(across, at)) < 1 for across in self.across)
        return first & second & third

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        return self.middle, self.radius

    def crossing_at(self, entering):
        """A ray enters at the first of the two."""
        return jnp.where(entering, 0, 1).astype(jnp.int8)

    def _interval(self, ray: Ray):
        """Where the ray enters and by which pair of faces, where and by which it leaves, both counted from where it is
        closest to the middle, and whether it meets the box at all.
        """
        along, at = closest(ray, self.middle)
        none = jnp.zeros(along.shape, jnp.int32)
        enters, leaves = (jnp.full_like(along, -jnp.inf), none), (jnp.full_like(along, jnp.inf), none)
        beside = none < 0
        for face, across in enumerate(self.across):
            place, towards = dot(across, at), dot(across, ray.direction)
            level = towards == 0
            sign = jnp.where(towards > 0, 1, -1).astype(along.dtype)
            first, last = (safe_divide(side * sign - place, towards) for side in (-1, 1))
            beside = beside | (level & (abs(place) > 1))
            enters = where(~level & (first > enters[0]), (first, none + face), enters)
            leaves = where(~level & (last < leaves[0]), (last, none + face), leaves)
        enters, leaves = ((finite(reach), face) for reach, face in (enters, leaves))
        return along, enters, leaves, ~beside & (enters[0] < leaves[0])


class Box(AbstractObject):
    """A box between two corners, its sides along the axes, metres; a solid. Raises `SceneError` where it has no
    volume.
    """

    TYPE: ClassVar[str] = "box"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("minimum", "vector", "The corner with the smallest x, y and z, metres.", unit="m", scale="unbounded",
            moves="rays"),
        Row("maximum", "vector", "The corner with the largest x, y and z, metres.", unit="m", scale="unbounded",
            moves="rays"),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Boxes
    CONVEX: ClassVar[bool] = True

    minimum: Float[Array, "3"]
    maximum: Float[Array, "3"]
    sides: Float[Array, "3 3"] | None
    """Of a box that has been turned: the ways along its sides, (side, xyz), in metres; one corner is `minimum`."""
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, minimum, maximum, material: str, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material, self.sides = name, material, None
        read_rows(self, place, minimum=minimum, maximum=maximum)
        check_corners(self.minimum, self.maximum, place)

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """One corner, and the ways along the sides from there."""
        return [stacked([thing.minimum for thing in objects]), stacked([thing.along_sides() for thing in objects])]

    @classmethod
    def family(cls, corner, sides) -> Boxes:
        first, second, third = (vec3(sides[..., k, :]) for k in range(3))
        middle = vec3(corner) + (first + second + third) * 0.5
        faces = cross(second, third), cross(third, first), cross(first, second)
        over = safe_divide(2, dot(first, faces[0]))
        diagonals = (first + second + third, first + second - third, first - second + third, second + third - first)
        longest = jnp.stack([dot(d, d) for d in diagonals]).max(axis=0)
        across = faces[0] * over, faces[1] * over, faces[2] * over
        return Boxes(middle, across, 0.5 * jnp.sqrt(longest))

    def along_sides(self):
        """The ways along the sides (side, xyz)."""
        if self.sides is not None:
            return self.sides
        size = self.maximum - self.minimum
        return jnp.diag(size) if is_traced(size) else np.diag(np.asarray(size))

    def transformed(self, linear, shift, place: str) -> "Box":
        corner = linear @ self.minimum + shift
        return changed(self, minimum=corner, maximum=linear @ self.maximum + shift, sides=self.along_sides() @ linear.T)


def check_corners(minimum, maximum, place: str) -> None:
    """Raise `SceneError` unless each number of the one is below that of the other."""
    if is_traced(minimum) or is_traced(maximum) or bool((np.asarray(minimum) < np.asarray(maximum)).all()):
        return
    raise SceneError(f"{place}: minimum = {listed(minimum)}, maximum = {listed(maximum)}; allowed is a minimum below "
                     "maximum in x, y and z")  # fmt: skip
