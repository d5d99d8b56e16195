"""Quadrics: ellipsoids, paraboloids, hyperboloids, cones and cylinders without end, saddles, pairs of planes."""

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
from ._box import check_corners
from ._implicit import finite, quadratic, settled
from ._object import AbstractObject

TERMS = ("xx", "yy", "zz", "xy", "xz", "yz", "x", "y", "z", "1")
"""What the coefficients multiply."""
LEAST = 1e-5
"""Determinant of what counts as an ellipsoid, in cubes of the trace: axes to 1 : 100 or so."""


class Quadrics(AbstractSurfaces):
    """Q(p) = p.A p + b.p + c = 0 for p = (x - origin) taken into the frame of the quadric; inside where Q < 0.

    What has an interval `low` to `high` of p is cut off there and stays open.
    """

    SOLID: ClassVar[bool] = True

    square: Vec3
    """Coefficients of xx, yy, zz."""
    mixed: Vec3
    """Of yz, xz, xy."""
    linear: Vec3
    constant: Float[Array, "*n"]
    low: Vec3
    high: Vec3
    origin: Vec3
    into: tuple[Vec3, Vec3, Vec3]
    """Rows of the matrix that takes a way into the frame."""
    middle: Vec3
    """A point of the frame near which the quadric is, from where rays are counted."""
    ball: tuple[Vec3, Float[Array, "*n"]]
    """The bounding sphere."""

    def crossings(self, ray: Ray, on_it, inwards):
        """Where Q falls through 0 along the ray, which enters there, and where it rises.

        A line meets a quadric twice at most: one that starts on it has the other crossing ahead where Q, as it leaves,
        has its second root on that side.
        """
        at, way, along, falls, rises, there, a = self._roots(ray, on_it)
        found = []
        for reach, other_side in ((falls, ~inwards & (a < 0)), (rises, inwards & (a > 0))):
            inside = self._within(at + way * finite(reach)) & jnp.isfinite(reach)
            distance = along + reach
            met = there & inside & jnp.where(on_it, other_side, distance > 0)
            found.append(jnp.where(met, jnp.where(on_it, jnp.maximum(distance, 0), distance), jnp.inf))
        return tuple(found)

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point of a crossing, differentiable in all that Q depends on."""
        _, _, along, falls, rises, _, _ = jax.lax.stop_gradient(self._roots(ray, jnp.ones(ray.origin.shape, bool)))
        entering = crossing == 0
        reach = finite(jnp.where(entering, falls, rises))
        at, way = self._taken(ray, along)
        at = at + way * reach
        distance = settled(along + reach, self._value(at), dot(self._gradient(at), way))
        at = at + way * (distance - jax.lax.stop_gradient(distance))
        gradient, (x, y, z) = self._gradient(at), self.into
        return distance, normalise(x * gradient.x + y * gradient.y + z * gradient.z), ray.at(distance), entering

    def contains(self, point: Vec3):
        """Inside of what nothing cuts off; what is open holds no volume."""
        at = self._inwards(point - self.origin)
        return ~(jnp.isfinite(self.low.x)) & (self._value(at) < 0)

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        return self.ball

    def crossing_at(self, entering):
        """A ray enters where Q falls."""
        return jnp.where(entering, 0, 1).astype(jnp.int8)

    def _inwards(self, way: Vec3) -> Vec3:
        """A way in the frame of the quadric."""
        return Vec3(*(dot(row, way) for row in self.into))

    def _taken(self, ray: Ray, along) -> tuple[Vec3, Vec3]:
        """The point of the ray at a distance, and its direction, in the frame: not of unit length there, so that
        distances stay what they are.
        """
        way = self._inwards(ray.direction)
        return self._inwards(ray.origin - self.origin) + way * along, way

    def _roots(self, ray: Ray, touched):
        """Point and direction in the frame, from what distance the roots are counted, and the roots."""
        start, way = self._taken(ray, 0)
        along = -safe_divide(dot(start - self.middle, way), dot(way, way))
        at = start + way * along
        a, h = self._curved(way), 0.5 * dot(self._gradient(at), way)
        falls, rises, there = quadratic(a, h, self._value(at), touched)
        gap = abs(rises - falls)
        return at, way, along, self._polished(at, way, falls, gap), self._polished(at, way, rises, gap), there, a

    def _polished(self, at: Vec3, way: Vec3, reach, gap):
        """One step of Newton's, where it is short against the way to the other root."""
        here = at + way * finite(reach)
        step = safe_divide(self._value(here), dot(self._gradient(here), way))
        return jnp.where(abs(step) < 0.1 * gap, reach - step, reach)

    def _curved(self, way: Vec3):
        """way.A way."""
        mixed = Vec3(way.y * way.z, way.x * way.z, way.x * way.y)
        return dot(self.square, way * way) + dot(self.mixed, mixed)

    def _value(self, at: Vec3):
        return self._curved(at) + dot(self.linear, at) + self.constant

    def _gradient(self, at: Vec3) -> Vec3:
        s, m = self.square, self.mixed
        return self.linear + Vec3(
            2 * s.x * at.x + m.z * at.y + m.y * at.z,
            m.z * at.x + 2 * s.y * at.y + m.x * at.z,
            m.y * at.x + m.x * at.y + 2 * s.z * at.z,
        )

    def _within(self, at: Vec3):
        """Is a point of the frame where the quadric is not cut off?"""
        met = (at.x >= self.low.x) & (at.x <= self.high.x) & (at.y >= self.low.y) & (at.y <= self.high.y)
        return met & (at.z >= self.low.z) & (at.z <= self.high.z)


class Quadric(AbstractObject):
    """The surface a xx + b yy + c zz + d xy + e xz + f yz + g x + h y + i z + j = 0, metres; inside where that is < 0.

    `minimum` and `maximum` cut it off by a box, which leaves it open: a sheet with an inner side, and no solid. Far
    from the origin of its coordinates the coefficients have no digits left for it: write it about its own middle, and
    move it there with `translate`. Raises `SceneError` where all coefficients but the last are 0.
    """

    TYPE: ClassVar[str] = "quadric"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("coefficients", "numbers", "Of xx, yy, zz, xy, xz, yz, x, y, z and 1; the sum is below 0 inside.",
            parts=TERMS, scale="unbounded", moves="rays"),
        Row("minimum", "vector", "With maximum: the box outside of which it is cut off, metres.", unit="m",
            default=None, scale="unbounded", moves="rays"),
        Row("maximum", "vector", "See minimum.", unit="m", default=None, scale="unbounded", moves="rays"),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Quadrics

    coefficients: Float[Array, "10"]
    minimum: Float[Array, "3"] | None
    maximum: Float[Array, "3"] | None
    frame: Float[Array, "3 4"] | None
    """Of one that has been moved or turned: what takes a point of its own coordinates to where it is."""
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, coefficients, material: str, minimum=None, maximum=None, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material, self.frame = name, material, None
        read_rows(self, place, coefficients=coefficients, minimum=minimum, maximum=maximum)
        if not is_traced(self.coefficients) and not np.any(np.asarray(self.coefficients)[:9]):
            raise SceneError(f"{place}: coefficients = {listed(self.coefficients)}; allowed is one other than 0 among "
                             "the first nine")  # fmt: skip
        if (self.minimum is None) != (self.maximum is None):
            raise SceneError(f"{place}: one of minimum and maximum is stated; allowed are both or neither")
        if self.minimum is not None:
            check_corners(self.minimum, self.maximum, place)

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """Coefficients, the corners of the box, infinite where there is none, and the frames."""

        def corner(value, endless: float):
            return np.full(3, endless) if value is None else value

        low, high = (
            [corner(getattr(thing, key), end) for thing in objects]
            for key, end in (("minimum", -np.inf), ("maximum", np.inf))
        )
        dtype = objects[0].coefficients.dtype
        frames = [np.eye(3, 4) if thing.frame is None else thing.frame for thing in objects]
        parts = ([thing.coefficients for thing in objects], low, high, frames)
        return [jnp.asarray(stacked(part)).astype(dtype) for part in parts]

    @classmethod
    def family(cls, coefficients, low, high, frame) -> Quadrics:
        xx, yy, zz, xy, xz, yz, x, y, z, constant = (coefficients[..., k] for k in range(10))
        turn, origin = frame[..., :3], vec3(frame[..., 3])
        into = _inverse(turn)
        bare = Vec3(xx, yy, zz), Vec3(yz, xz, xy), Vec3(x, y, z)
        still = jax.lax.stop_gradient((*bare, constant, vec3(low), vec3(high), turn))
        middle, (ball, radius) = _extent(*still)
        # The ball goes along with the origin, also in a derivative (see `scene._motion`).
        return Quadrics(*bare, constant, vec3(low), vec3(high), origin, into, middle, (ball + origin, radius))

    def transformed(self, linear, shift, place: str) -> "Quadric":
        turn, away = (np.eye(3), np.zeros(3)) if self.frame is None else (self.frame[:, :3], self.frame[:, 3])
        whole = jnp if any(map(is_traced, (linear, shift, turn))) else np
        placed = whole.concatenate([linear @ turn, (linear @ away + shift)[:, None]], axis=1)
        return changed(self, frame=placed)

    def moved(self, by: np.ndarray) -> "Quadric":
        """Q(x - by) = 0, its coefficients in float64 where they are known."""
        if is_traced(self.coefficients) or self.frame is not None or is_traced(self.minimum):
            return self.transformed(np.eye(3), by, "")
        by, k = np.asarray(by, np.float64), np.asarray(self.coefficients, np.float64)
        square = np.diag(k[:3]) + 0.5 * np.asarray([[0, k[3], k[4]], [k[3], 0, k[5]], [k[4], k[5], 0]])
        constant = by @ square @ by - k[6:9] @ by + k[9]
        corners = {} if self.minimum is None else {key: getattr(self, key) + by for key in ("minimum", "maximum")}
        return changed(self, coefficients=np.asarray([*k[:6], *(k[6:9] - 2 * square @ by), constant]), **corners)


def _inverse(matrix) -> tuple[Vec3, Vec3, Vec3]:
    """Rows of the inverse of a matrix (..., 3, 3), by cross products of its columns."""
    first, second, third = (vec3(matrix[..., :, k]) for k in range(3))
    rows = cross(second, third), cross(third, first), cross(first, second)
    over = safe_divide(1, dot(first, rows[0]))
    return rows[0] * over, rows[1] * over, rows[2] * over


def _times(rows: tuple[Vec3, Vec3, Vec3], v: Vec3) -> Vec3:
    return Vec3(*(dot(row, v) for row in rows))


def _extent(square: Vec3, mixed: Vec3, linear: Vec3, constant, low: Vec3, high: Vec3, turn):
    """A point of the frame near which a quadric is, and middle and radius of the smallest sphere around an ellipsoid,
    or around the box of what is cut off, from its origin. No derivatives.
    """
    boxed = jnp.isfinite(low.x)
    rows = jnp.stack([2 * square.x, mixed.z, mixed.y, mixed.z, 2 * square.y, mixed.x, mixed.y, mixed.x, 2 * square.z])
    largest = jnp.maximum(abs(rows).max(axis=0), jnp.finfo(constant.dtype).tiny)
    scaled = jnp.moveaxis(rows / largest, 0, -1).reshape(*constant.shape, 3, 3)
    # Solve for where the gradient is 0, and where that is a line or a plane, for a point on it.
    pull = vec3(scaled[..., 0, :]), vec3(scaled[..., 1, :]), vec3(scaled[..., 2, :])
    towards = _times(pull, linear * (-1 / largest))
    solved = _times(_inverse(scaled @ scaled + 1e-6 * jnp.eye(3, dtype=scaled.dtype)), towards)
    low, high = (where(boxed, corner, jax.tree.map(jnp.zeros_like, corner)) for corner in (low, high))
    middle = where(boxed, (low + high) * 0.5, solved)
    # Bound an ellipsoid that is not too slender to be told from a cylinder, by its longest axis.
    second = scaled[..., 0, 0] * scaled[..., 1, 1] - scaled[..., 0, 1] ** 2
    determinant = dot(pull[0], cross(pull[1], pull[2]))
    trace = jnp.trace(scaled, axis1=-2, axis2=-1)
    is_round = (scaled[..., 0, 0] > 0) & (second > 0) & (trace > 0) & (determinant > LEAST * trace**3)
    inverse = _inverse(jnp.where(is_round[..., None, None], scaled, jnp.eye(3, dtype=scaled.dtype)))
    centre = where(is_round, _times(inverse, linear * (-1 / largest)), middle)
    depth = jnp.maximum(-(constant + 0.5 * dot(linear, centre)) / largest, 0)
    spread = turn @ jnp.stack([row.stacked() for row in inverse], axis=-2) @ jnp.swapaxes(turn, -1, -2)
    radius = jnp.where(is_round, jnp.sqrt(2 * depth * _largest_eigenvalue(spread)), jnp.inf)
    # Bound the box, by the longest of its diagonals.
    half = (high - low).stacked() * 0.5
    signs = jnp.asarray([[1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]], half.dtype)
    corners = vec3((signs * half[..., None, :]) @ jnp.swapaxes(turn, -1, -2))
    reach = jnp.sqrt(dot(corners, corners)).max(axis=-1)
    tighter = boxed & (reach < radius)
    inner = where(tighter, middle, centre)
    ball = vec3((turn @ inner.stacked()[..., None])[..., 0])
    return middle, (ball, jnp.where(tighter, reach, radius))


def _largest_eigenvalue(matrix):
    """Of symmetric matrices (..., 3, 3), by the cosine of a third of an angle."""
    mean = jnp.trace(matrix, axis1=-2, axis2=-1) / 3
    away = matrix - mean[..., None, None] * jnp.eye(3, dtype=matrix.dtype)
    size = jnp.sqrt((away * away).sum(axis=(-2, -1)) / 6)
    first, second, third = (vec3(away[..., k, :]) for k in range(3))
    cosine = jnp.clip(safe_divide(0.5 * dot(first, cross(second, third)), size**3), -1, 1)
    return mean + 2 * size * jnp.cos(jnp.arccos(cosine) / 3)
