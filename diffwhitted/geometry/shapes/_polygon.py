"""Plane polygons, triangles among them."""

import equinox as eqx
import jax.numpy as jnp

from ...numerics._coverage import Linear
from ...numerics._safe import length, normalise, safe_divide
from ...numerics._vector import Vec3, cross, dot, where
from .._footprint import Footprint, on_surface
from .._hit import Hit
from .._ray import Ray
from ._plane import Planes


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

    def outline(self, ray: Ray, footprint: Footprint):
        """Distance in the plane from where the ray meets it to the nearest side, positive inside; and how far that is."""
        plane = self.carrier()
        distance, _, point = plane.surface(ray, None)
        hit = Hit(None, None, point, where(self.side(ray), plane.normal, -plane.normal), distance)
        met = on_surface(ray, footprint, hit)
        inside = jnp.where(self._outlines(plane, point), 1, -1)
        nearest, outwards = jnp.full(distance.shape, jnp.inf, distance.dtype), plane.normal
        for k in range(self.vertices.x.shape[-1]):
            away, normal = self._from_side(k, plane, point, inside)
            nearest, outwards = where(abs(away) < abs(nearest), (away, normal), (nearest, outwards))
        return Linear(-nearest, *(-dot(outwards, side.origin) for side in met.sides())), distance

    def _side(self, k: int) -> tuple[Vec3, Vec3]:
        """Where side k starts, and the way to its end."""
        corners = self.vertices
        start, end = (Vec3(*(c[..., i % c.shape[-1]] for c in (corners.x, corners.y, corners.z))) for i in (k, k + 1))
        return start, end - start

    def _from_side(self, k: int, plane: Planes, point: Vec3, inside):
        """Signed distance of a point of the plane from side k (negative inside), and its direction of growth."""
        start, side = self._side(k)
        long = dot(side, side) > 0
        from_start = point - start
        share = safe_divide(dot(from_start, side), dot(side, side))
        normal = normalise(cross(side, plane.normal))
        to_corner = from_start - side * jnp.clip(share, 0, 1)
        beside = long & (share > 0) & (share < 1)
        away = where(beside, dot(normal, from_start), -inside * length(to_corner))
        return away, where(beside, normal, normalise(to_corner) * -inside)

    def near_outline(self, ray: Ray, reach, growth):
        """May one of the sides lie within `reach` + `growth` times the distance of the ray's line?"""
        found = jnp.zeros(ray.origin.shape, bool)
        for k in range(self.vertices.x.shape[-1]):
            start, side = self._side(k)
            to_start = start - ray.origin
            across = cross(ray.direction, side)
            long = jnp.sqrt(dot(side, side))
            around = reach + growth * (jnp.sqrt(dot(to_start, to_start)) + long)
            moment, middle = dot(to_start, across), to_start + side * 0.5
            middle = middle - ray.direction * dot(middle, ray.direction)
            apart = around + 0.5 * long
            found = found | (
                (moment * moment <= around * around * dot(across, across)) & (dot(middle, middle) <= apart * apart)
            )
        return found

    def side(self, ray: Ray):
        """Does a ray that only just meets the shape come from its outer side?"""
        return self.carrier().side(ray)

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        middle = Vec3(*(c.mean(axis=-1) for c in (self.vertices.x, self.vertices.y, self.vertices.z)))
        away = self.vertices - Vec3(*(c[..., None] for c in (middle.x, middle.y, middle.z)))
        return middle, jnp.sqrt(dot(away, away).max(axis=-1))

    def contains(self, point: Vec3):
        """A polygon is a sheet: it holds no volume of its own."""
        return jnp.zeros(point.shape, bool)

    def _outlines(self, plane: Planes, point: Vec3):
        """Even-odd rule in the coordinate plane that the polygon faces most.

        Each side is taken from its lower end, so that two polygons with a side in common, which run along it in
        opposite ways, round its crossing alike: no point falls between them.
        """
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
            (u0, v0), (u1, v1) = where((v0 > v1) | ((v0 == v1) & (u0 > u1)), ((u1, v1), (u0, v0)), ((u0, v0), (u1, v1)))
            spans = (v0 > v) != (v1 > v)
            rise = jnp.where(v1 == v0, 1, v1 - v0)
            inside ^= spans & (u < (u1 - u0) * (v - v0) / rise + u0)
        return inside
