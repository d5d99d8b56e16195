"""Spheres."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...numerics._coverage import Linear
from ...numerics._safe import length, normalise, safe_divide, safe_sqrt
from ...numerics._vector import Vec3, dot, where
from .._footprint import Footprint
from .._ray import Ray


class Spheres(eqx.Module):
    """Spheres by centre and radius (arrays over the spheres, or over rays after a look-up)."""

    centre: Vec3
    radius: Float[Array, "*n"]

    def crossings(self, ray: Ray, on_it, inwards):
        """Distances of the crossings ahead, in order; infinity where there is none.

        Hearn and Baker (14-58): s = u.dP -+ sqrt(r**2 - |dP - (u.dP) u|**2), the form that survives a
        radius much smaller than the distance |dP|.
        """
        _, middle, _, half_chord_squared = self._chord(ray)
        half_chord = jnp.sqrt(jnp.maximum(half_chord_squared, 0))
        met = half_chord_squared > 0
        near, far = middle - half_chord, middle + half_chord
        near = jnp.where(met & (near > 0) & ~on_it, near, jnp.inf)
        far = jnp.where(met & (far > 0) & (~on_it | inwards), far, jnp.inf)
        return near, far

    def first_crossing(self, ray: Ray, on_it, inwards):
        """Distance of the nearest crossing (infinity if none) and whether the ray enters there."""
        near, far = self.crossings(ray, on_it, inwards)
        entering = jnp.isfinite(near)
        return jnp.where(entering, near, far), entering

    def carrier(self) -> "Spheres":
        """The unbounded surface that carries the shape: the sphere itself."""
        return self

    def surface(self, ray: Ray, entering):
        """Distance, outward unit normal and point of the recorded crossing, differentiable.

        The normal comes from the offset (dP - (u.dP) u) and the half chord, and for a far or small
        sphere the point comes from centre and normal: both keep their digits where `ray.at(distance)`
        has lost them to the distance. Edge: on the silhouette, where the half chord vanishes, its
        derivative is 0 by `safe_sqrt`.
        """
        to_centre, middle, miss, half_chord_squared = self._chord(ray)
        half_chord = safe_sqrt(half_chord_squared)
        half_chord = jnp.where(entering, -half_chord, half_chord)
        distance = middle + half_chord
        outward = (ray.direction * half_chord - miss) * safe_divide(1, self.radius)
        point = where(self.radius < distance, self.centre + outward * self.radius, ray.at(distance))
        return distance, outward, point

    def outline(self, ray: Ray, footprint: Footprint):
        """r - |q| with q from the ray's line to the centre: positive where the line meets the sphere; and where it is closest."""
        _, middle, miss, _ = self._chord(ray)
        sideways = normalise(miss)

        def along(side: Ray):
            return dot(sideways, side.origin + side.direction * middle)

        return Linear(self.radius - length(miss), along(footprint.across), along(footprint.down)), middle

    def near_outline(self, ray: Ray, reach, growth):
        """May the outline lie within `reach` + `growth` times the distance of the ray's line? No derivatives."""
        _, middle, miss, _ = self._chord(ray)
        around = reach + growth * abs(middle)
        low, high = jnp.maximum(self.radius - around, 0), self.radius + around
        from_line = dot(miss, miss)
        return (from_line >= low * low) & (from_line <= high * high)

    def side(self, ray: Ray):
        """Does a ray that only just meets the shape come from its outer side?"""
        return jnp.ones(ray.origin.shape, bool)

    def curvature(self):
        """The outward unit normal changes by this times a small step along the surface."""
        return safe_divide(1, self.radius)

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        return self.centre, self.radius

    def contains(self, point: Vec3):
        offset = point - self.centre
        return dot(offset, offset) < self.radius * self.radius

    def _chord(self, ray: Ray):
        to_centre = self.centre - ray.origin
        middle = dot(to_centre, ray.direction)
        miss = to_centre - ray.direction * middle
        return to_centre, middle, miss, self.radius * self.radius - dot(miss, miss)
