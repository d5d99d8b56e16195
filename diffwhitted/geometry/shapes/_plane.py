"""Infinite planes, each the boundary of the half space that its normal points away from."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...numerics._coverage import Linear
from ...numerics._safe import safe_divide
from ...numerics._vector import Vec3, dot
from .._footprint import Footprint
from .._ray import Ray

HORIZON = 1e30
"""Metres; how far away a ray that runs along a plane is taken to come near it."""


class Planes(eqx.Module):
    """Planes normal.x = offset with unit normals (arrays over the planes, or over rays)."""

    normal: Vec3
    offset: Float[Array, "*n"]

    def crossings(self, ray: Ray, on_it, inwards):
        """Distance of the crossing ahead (infinity if none), as a tuple of one."""
        return (self.first_crossing(ray, on_it, inwards)[0],)

    def first_crossing(self, ray: Ray, on_it, inwards):
        """Distance of the crossing (infinity if none) and whether the ray enters there.

        Hearn and Baker (14-62): s = -(D + N.P0) / (N.u), here with D = -offset.
        """
        del inwards
        distance, entering = self._crossing(ray)
        return jnp.where((distance > 0) & ~on_it, distance, jnp.inf), entering

    def carrier(self) -> "Planes":
        """The unbounded surface that carries the shape: the plane itself."""
        return self

    def surface(self, ray: Ray, entering):
        """Distance, outward unit normal and point, differentiable. Edge: a parallel ray gives distance 0."""
        del entering
        distance = self._crossing(ray)[0]
        return distance, self.normal, ray.at(distance)

    def outline(self, ray: Ray, footprint: Footprint):
        """N.u, positive where the ray heads for the plane: the horizon, further away than anything else."""
        sign = jnp.where(self.side(ray), -1, 1).astype(ray.origin.dtype)
        rise = Linear(
            *(sign * dot(self.normal, d) for d in (ray.direction, footprint.across.direction, footprint.down.direction))
        )
        return rise, jnp.full_like(sign, HORIZON)

    def near_outline(self, ray: Ray, reach, growth):
        """May the horizon lie within the angle `growth` of the ray?"""
        return abs(dot(self.normal, ray.direction)) <= growth

    def side(self, ray: Ray):
        """Does a ray that only just meets the shape come from its outer side?"""
        return dot(self.normal, ray.origin) >= self.offset

    def curvature(self):
        """The unit normal is the same everywhere."""
        return jnp.zeros_like(self.offset)

    def bounding(self):
        """Middle and radius of a sphere around the shape, which has no end."""
        return self.normal * self.offset, jnp.full_like(self.offset, jnp.inf)

    def contains(self, point: Vec3):
        return dot(self.normal, point) < self.offset

    def _crossing(self, ray: Ray):
        towards = dot(self.normal, ray.direction)
        distance = safe_divide(self.offset - dot(self.normal, ray.origin), towards)
        return distance, towards < 0
