"""Plane polygons, triangles among them."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._safe import normalise
from .._vector import Vec3, cross, dot
from ._plane import Planes
from ._ray import Ray


class Polygons(eqx.Module):
    """Simple plane polygons, convex or not.

    `vertices` has one trailing axis; shorter polygons repeat their last vertex, which adds edges of
    no length. The outer side is the one from which the vertices run counter-clockwise.
    """

    vertices: Vec3

    def carrier(self) -> Planes:
        """The plane that carries the polygon; its normal by Newell's sum over the edges."""
        first = Vec3(*(c[..., :1] for c in (self.vertices.x, self.vertices.y, self.vertices.z)))
        spokes = self.vertices - first
        following = Vec3(*(jnp.roll(c, -1, axis=-1) for c in (spokes.x, spokes.y, spokes.z)))
        doubled_area = cross(spokes, following)
        normal = normalise(Vec3(*(c.sum(axis=-1) for c in (doubled_area.x, doubled_area.y, doubled_area.z))))
        corner = Vec3(first.x[..., 0], first.y[..., 0], first.z[..., 0])
        return Planes(normal, dot(normal, corner))

    def crossings(self, ray: Ray, on_it, inwards):
        return (self.first_crossing(ray, on_it, inwards)[0],)

    def first_crossing(self, ray: Ray, on_it, inwards):
        """The crossing of the plane (Hearn and Baker 14-62), where it lies inside the outline."""
        plane = self.carrier()
        distance, entering = plane.first_crossing(ray, on_it, inwards)
        met = jnp.isfinite(distance)
        inside = self._outlines(plane, ray.at(jnp.where(met, distance, 0)))
        return jnp.where(met & inside, distance, jnp.inf), entering

    def contains(self, point: Vec3):
        """A polygon is a sheet: it holds no volume of its own."""
        return jnp.zeros(point.shape, bool)

    def _outlines(self, plane: Planes, point: Vec3):
        """Even-odd rule in the coordinate plane that the polygon faces most."""
        ax, ay, az = abs(plane.normal.x), abs(plane.normal.y), abs(plane.normal.z)
        drop_x = (ax >= ay) & (ax >= az)
        drop_y = ~drop_x & (ay >= az)

        def flat(v: Vec3, along_x, along_y):
            return jnp.where(along_x, v.y, v.x), jnp.where(along_x | along_y, v.z, v.y)

        corner_u, corner_v = flat(self.vertices, drop_x[..., None], drop_y[..., None])
        u, v = flat(point, drop_x, drop_y)
        inside = jnp.zeros(jnp.shape(u), bool)
        sides = corner_u.shape[-1]
        for k in range(sides):
            u0, v0 = corner_u[..., k], corner_v[..., k]
            u1, v1 = corner_u[..., (k + 1) % sides], corner_v[..., (k + 1) % sides]
            spans = (v0 > v) != (v1 > v)
            rise = jnp.where(v1 == v0, 1, v1 - v0)
            inside ^= spans & (u < (u1 - u0) * (v - v0) / rise + u0)
        return inside
