"""Cylinders and cones cut off square to their axis: one family for both."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..geometry import AbstractSurfaces, Ray
from ..numerics._safe import normalise, safe_divide
from ..numerics._vector import Vec3, dot, where
from ._implicit import ahead, closest, finite, quadratic, settled


class Frusta(AbstractSurfaces):
    """Cones |rho| = r(z) = radius + slope z for -half <= z <= half along a unit axis from a middle; those that are
    `capped` are closed by discs.
    """

    SOLID: ClassVar[bool] = True

    middle: Vec3
    axis: Vec3
    half: Float[Array, "*n"]
    """Of the height."""
    radius: Float[Array, "*n"]
    """At the middle."""
    slope: Float[Array, "*n"]
    """What the radius grows by, a metre of height."""
    capped: Bool[Array, "*n"]

    def crossings(self, ray: Ray, on_it, inwards):
        """Where the ray enters and where it leaves: of what is capped by the side or by a cap.

        Hearn and Baker (14-58) in the plane square to the axis: a s**2 + 2 h s + c = |rho|**2 - r(z)**2.
        """
        along, enters, leaves, met = self._interval(ray)
        return ahead(along + enters[0], along + leaves[0], met, on_it, inwards)

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point of the side or of the cap that the crossing is on, differentiable."""
        along, enters, leaves, _ = jax.lax.stop_gradient(self._interval(ray))
        entering = crossing == 0
        reach, on_side = where(entering, enters, leaves)
        reach = finite(reach)
        _, at = closest(ray, self.middle)
        at = at + ray.direction * reach
        # Find how far F is from 0 there and how it changes along the ray, for the side and for the cap.
        z, rise = dot(at, self.axis), dot(ray.direction, self.axis)
        outwards = at - self.axis * z
        here = self.radius + self.slope * z
        top = jnp.where(jax.lax.stop_gradient(z) > 0, 1, -1).astype(z.dtype)
        value = where(on_side, dot(outwards, outwards) - here * here, top * z - self.half)
        across = 2 * (dot(outwards, ray.direction) - here * self.slope * rise)
        distance = settled(along + reach, value, where(on_side, across, top * rise))
        at = at + ray.direction * (distance - jax.lax.stop_gradient(distance))
        side = normalise(normalise(at - self.axis * dot(at, self.axis)) - self.axis * self.slope)
        return distance, where(on_side, side, self.axis * top), self.middle + at, entering

    def contains(self, point: Vec3):
        at = point - self.middle
        z = dot(at, self.axis)
        outwards, here = at - self.axis * z, self.radius + self.slope * z
        return self.capped & (abs(z) < self.half) & (dot(outwards, outwards) < here * here)

    def bounding(self):
        """Middle and radius of the smallest sphere around the shape: as far from both rims, if that is between them."""
        shift = jnp.clip(self.radius * self.slope, -self.half, self.half)
        low, high = self.radius - self.slope * self.half, self.radius + self.slope * self.half
        below, above = self.half + shift, self.half - shift
        squared = jnp.maximum(low * low + below * below, high * high + above * above)
        return self.middle + self.axis * shift, jnp.sqrt(squared)

    def crossing_at(self, entering):
        """A ray enters at the first of the two."""
        return jnp.where(entering, 0, 1).astype(jnp.int8)

    def _interval(self, ray: Ray):
        """Where the ray enters and leaves, counted from where it is closest to the middle, whether either is on the
        side, and whether it meets the shape at all.
        """
        along, at = closest(ray, self.middle)
        z, rise = dot(at, self.axis), dot(ray.direction, self.axis)
        outwards, spread = at - self.axis * z, ray.direction - self.axis * rise
        # Count the side from where the line is closest to it, within what bounds the shape.
        a = dot(spread, spread) - (self.slope * rise) * (self.slope * rise)
        widest = self.radius + abs(self.slope) * self.half
        reach = self.half + widest
        shift = safe_divide((self.radius + self.slope * z) * self.slope * rise - dot(outwards, spread), a)
        shift = jnp.clip(shift, -reach, reach)
        outwards, here = outwards + spread * shift, self.radius + self.slope * (z + rise * shift)
        away = jnp.sqrt(dot(outwards, outwards))
        c, h = (away - here) * (away + here), dot(outwards, spread) - here * self.slope * rise
        falls, rises, there = quadratic(a, h, c, a < 0)
        # Of the two cones that meet in the apex, the one that is there begins or ends the way inside.
        widens = self.slope * rise > 0
        first = where(a < 0, jnp.where(widens, falls, -jnp.inf), falls) + shift
        last = where(a < 0, jnp.where(widens, jnp.inf, rises), rises) + shift
        lengthwise = (a == 0) & (h == 0)
        first, last = jnp.where(lengthwise, -jnp.inf, first), jnp.where(lengthwise, jnp.inf, last)
        there = jnp.where(lengthwise, c < 0, there)
        # Between the planes of the caps.
        level = rise == 0
        low, high = (safe_divide(jnp.where(rise > 0, end, -end) - z, rise) for end in (-self.half, self.half))
        low, high = jnp.where(level, -jnp.inf, low), jnp.where(level, jnp.inf, high)
        between = ~level | (abs(z) <= self.half)
        solid_first, solid_last = jnp.maximum(first, low), jnp.minimum(last, high)
        whole = there & between & (solid_first < solid_last)
        # A tube has its side alone.
        begins, ends = (there & between & (low <= edge) & (edge <= high) for edge in (first, last))
        enters = jnp.where(self.capped, solid_first, jnp.where(begins, first, jnp.inf))
        leaves = jnp.where(self.capped, solid_last, jnp.where(ends, last, jnp.inf))
        met = jnp.where(self.capped, whole, begins | ends)
        return along, (enters, ~self.capped | (first >= low)), (leaves, ~self.capped | (last <= high)), met
