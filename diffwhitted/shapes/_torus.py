"""Tori."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._errors import SceneError
from ..geometry import AbstractSurfaces, Ray
from ..numerics._safe import normalise, rescaled, safe_divide, safe_sqrt
from ..numerics._vector import Vec3, dot, vec3
from ..records import Row, is_traced, listed, read_rows
from ._implicit import closest, settled
from ._object import AbstractObject

AROUND = 1.01
"""So many radii of the bounding sphere to either side of where a line is closest to the middle lie all roots."""
MOST_STEPS = 80
"""Of halving and Newton's steps; a dozen do."""


class Tori(AbstractSurfaces):
    """G = (rho - major)**2 + z**2 - minor**2 = 0, with z along a unit axis and rho away from it.

    Along a line G has the sign of a quartic s**4 + A s**2 + B s + C, counted from where the line is closest to the
    middle. The places where its slope is 0 part the line into four intervals, in which it falls, rises, falls and
    rises: each holds one crossing at most, whose number is that of its interval, and a ray enters at the even ones.
    """

    SOLID: ClassVar[bool] = True

    centre: Vec3
    axis: Vec3
    major: Float[Array, "*n"]
    minor: Float[Array, "*n"]

    def crossings(self, ray: Ray, on_it, inwards):
        """Distances of the four crossings.

        A ray that starts on it is on a crossing by which it goes the way that it does, in the interval where it starts
        or next to that; the later ones lie ahead.
        """
        along, at, ends = self._intervals(ray)
        start = -along
        begun = sum((start > end).astype(jnp.int32) for end in ends[1:4])
        # Number the crossing on which a ray starts.
        wrong = (begun % 2 == 0) != inwards
        to_next, to_last = (abs(_chosen(ends, begun + k) - start) for k in (1, 0))
        upwards = (begun == 0) | ((begun < 3) & (to_next < to_last))
        own = jnp.where(wrong, jnp.where(upwards, begun + 1, begun - 1), begun)
        # Find all four at once, along a new first axis: one loop makes a smaller program than four.
        number = jnp.arange(4).reshape(4, *(1 for _ in along.shape))
        reach, there = self._root(at, ray.direction, jnp.stack(ends[:4]), jnp.stack(ends[1:]), number)
        distance = jnp.maximum(along + reach, 0)
        met = there & jnp.where(on_it, own < number, along + reach > 0)
        # What has just gone in comes out, whatever rounding says.
        lost = on_it & inwards & ~(met[1] | met[3])
        met = met | (lost & (own == number - 1))
        return tuple(jnp.where(met, distance, jnp.inf))

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point of a crossing, differentiable."""
        assert crossing is not None
        still = jax.lax.stop_gradient(self)
        along, at, ends = still._intervals(jax.lax.stop_gradient(ray))
        low, high = _chosen(ends, crossing), _chosen(ends, crossing + 1)
        reach, _ = still._root(at, jax.lax.stop_gradient(ray.direction), low, high, crossing)
        at = closest(ray, self.centre)[1] + ray.direction * reach
        value, slope = self._value(at, ray.direction)
        distance = settled(along + reach, value, slope)
        at = at + ray.direction * (distance - jax.lax.stop_gradient(distance))
        outwards = at - self.axis * dot(at, self.axis)
        normal = normalise(at - normalise(outwards) * self.major)
        return distance, normal, self.centre + at, crossing % 2 == 0

    def contains(self, point: Vec3):
        return self._value(point - self.centre, self.axis)[0] < 0

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        return self.centre, self.major + self.minor

    def crossing_at(self, entering):
        """A ray enters at the first of two."""
        return jnp.where(entering, 0, 1).astype(jnp.int8)

    def _value(self, at: Vec3, way: Vec3):
        """G at a place from the middle, and how fast it changes on the way."""
        z = dot(at, self.axis)
        outwards = at - self.axis * z
        away = safe_sqrt(dot(outwards, outwards))
        beyond = away - self.major
        radial = safe_divide(dot(outwards, way), away)
        return beyond * beyond + (z - self.minor) * (z + self.minor), 2 * (beyond * radial + z * dot(way, self.axis))

    def _intervals(self, ray: Ray) -> tuple[Float[Array, "*n"], Vec3, tuple[Float[Array, "*n"], ...]]:
        """From what distance s is counted, the place there from the middle, and the five ends of the four
        intervals.
        """
        along, here = closest(ray, self.centre)
        size = self.major + self.minor
        ring, tube = self.major / size, self.minor / size
        at = here * (1 / size)
        z, rise = dot(at, self.axis), dot(ray.direction, self.axis)
        # s**4 + bend s**2 + ... = (s**2 + at.at + ring**2 - tube**2)**2 - 4 ring**2 (s**2 + at.at - (z + rise s)**2).
        squared = 4 * ring * ring
        bend = 2 * (dot(at, at) + ring * ring - tube * tube) - squared * (1 - rise * rise)
        flat = _depressed_cubic(0.5 * bend, 0.5 * squared * z * rise)
        limit = AROUND * jnp.ones_like(along)
        ends = (-limit, *(jnp.clip(root, -AROUND, AROUND) for root in flat), limit)
        return along, here, tuple(end * size for end in ends)

    def _root(self, at: Vec3, way: Vec3, low, high, number: Int[Array, "*n"]):
        """Where G changes its sign between two places, and whether it does; where not, one of the two.

        Newton's steps, and halves of the interval where they leave it.
        """
        sign = jnp.where(number % 2 == 0, 1, -1).astype(low.dtype)
        begins, ends = (sign * self._value(at + way * reach, way)[0] for reach in (low, high))
        there = (begins > 0) & (ends < 0)
        low = jnp.where(there | (begins <= 0), low, high)
        high = jnp.where(there, high, low)
        near = 4 * float(jnp.finfo(low.dtype).eps) * (self.major + self.minor)

        def closer(state):
            steps, low, high, reach, _ = state
            value, slope = self._value(at + way * reach, way)
            before = sign * value > 0
            low, high = jnp.where(before, reach, low), jnp.where(before, high, reach)
            newton = reach - safe_divide(value, slope)
            inside = (newton > low) & (newton < high) & (slope != 0)
            following = jnp.where(inside, newton, 0.5 * (low + high))
            return steps + 1, low, high, following, there & (abs(following - reach) > near)

        state = jnp.int32(0), low, high, 0.5 * (low + high), there
        return jax.lax.while_loop(lambda s: (s[0] < MOST_STEPS) & s[4].any(), closer, state)[3], there


def _chosen(ends: tuple, number):
    """One of the ends for each ray."""
    found = ends[0]
    for k, end in enumerate(ends[1:], 1):
        found = jnp.where(number == k, end, found)
    return found


def _depressed_cubic(p, q) -> tuple[Float[Array, "*n"], ...]:
    """The real roots of s**3 + p s + q in order, the one root three times where there is one only. No derivatives."""
    third = jnp.maximum(-p / 3, 0)
    root = jnp.sqrt(third)
    three = 4 * third * third * third > q * q
    # Three: by the cosines of a third of an angle.
    cosine = jnp.clip(safe_divide(-0.5 * q, third * root), -1, 1)
    angle = jnp.arccos(cosine) / 3
    turns = [2 * root * jnp.cos(angle + turn) for turn in (2 * jnp.pi / 3, -2 * jnp.pi / 3, 0.0)]
    # One: Cardano's, in the form without a difference of like numbers.
    outer = jnp.cbrt(0.5 * abs(q) + jnp.sqrt(jnp.maximum(0.25 * q * q + p * p * p / 27, 0)))
    alone = -jnp.where(q > 0, 1, -1) * (outer - safe_divide(p / 3, outer))
    found = []
    for turned in turns:
        s = jnp.where(three, turned, alone)
        for _ in range(2):
            slope = 3 * s * s + p
            step = safe_divide((s * s + p) * s + q, slope)
            s = jnp.where(abs(step) < 0.1 * (abs(s) + root), s - step, s)
        found.append(s)
    first, second, third_root = found
    low, high = jnp.minimum(first, third_root), jnp.maximum(first, third_root)
    return low, jnp.clip(second, low, high), high


class Torus(AbstractObject):
    """A ring: centre, axis, the radius of the circle in the middle of the tube and that of the tube, metres; a solid.

    Raises `SceneError` unless minor_radius is below major_radius.
    """

    TYPE: ClassVar[str] = "torus"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("centre", "vector", "Centre, metres.", unit="m", scale="unbounded", moves="rays"),
        Row("axis", "direction", "About which it is round; any length but zero.", nonzero=True, scale="unbounded",
            moves="rays"),
        Row("major_radius", "number", "From the centre to the middle of the tube, metres.", unit="m", lowest=0,
            excluded=True, scale="log", moves="rays"),
        Row("minor_radius", "number", "Of the tube, metres.", unit="m", lowest=0, excluded=True, scale="log",
            moves="rays"),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Tori

    centre: Float[Array, "3"]
    axis: Float[Array, "3"]
    major_radius: Float[Array, ""]
    minor_radius: Float[Array, ""]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, centre, axis, major_radius, minor_radius, material: str, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        read_rows(self, place, centre=centre, axis=axis, major_radius=major_radius, minor_radius=minor_radius)
        radii = self.major_radius, self.minor_radius
        if not any(map(is_traced, radii)) and not radii[1] < radii[0]:
            raise SceneError(
                f"{place}: minor_radius = {listed(radii[1])}; allowed is less than major_radius = {listed(radii[0])}"
            )

    @classmethod
    def family(cls, centre, axis, major_radius, minor_radius) -> Tori:
        return Tori(vec3(centre), normalise(rescaled(vec3(axis))[0]), major_radius, minor_radius)
