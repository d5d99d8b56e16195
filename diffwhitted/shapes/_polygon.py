"""Plane polygons, triangles among them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import LEAST_COVERAGE, AbstractSurfaces, Footprint, Ray, outwards, steps_on_surface
from ..numerics._coverage import Linear, is_cut
from ..numerics._safe import length, normalise, power_of_two, safe_divide
from ..numerics._vector import Vec3, cross, dot, vec3, where
from ..records import Row, entries, is_traced, number_array, stacked
from ._object import AbstractObject
from ._plane import Planes


class Polygons(AbstractSurfaces):
    """Simple plane polygons, convex or not.

    `vertices` has one trailing axis; shorter polygons repeat their last vertex, which adds edges of
    no length. The outer side is the one from which the vertices run counter-clockwise.
    """

    FOOTPRINT: ClassVar[bool] = True
    BOUNDED: ClassVar[bool] = True

    vertices: Vec3

    def surface(self, ray: Ray, crossing):
        """That of the plane that carries the polygon."""
        return self.carrier().surface(ray, crossing)

    def carrier(self) -> Planes:
        """The plane that carries the polygon; its normal by Newell's sum over the edges."""
        first = Vec3(*(c[..., :1] for c in (self.vertices.x, self.vertices.y, self.vertices.z)))
        spokes = self.vertices - first
        # Only the direction is wanted: the square of an area would leave the range of numbers.
        largest = jax.lax.stop_gradient(
            jnp.maximum(jnp.maximum(abs(spokes.x), abs(spokes.y)), abs(spokes.z)).max(axis=-1, keepdims=True)
        )
        spokes = spokes * power_of_two(largest)
        following = Vec3(*(jnp.roll(c, -1, axis=-1) for c in (spokes.x, spokes.y, spokes.z)))
        doubled_area = cross(spokes, following)
        normal = normalise(Vec3(*(c.sum(axis=-1) for c in (doubled_area.x, doubled_area.y, doubled_area.z))))
        corner = Vec3(first.x[..., 0], first.y[..., 0], first.z[..., 0])
        return Planes(normal, dot(normal, corner))

    def crossings(self, ray: Ray, on_it, inwards):
        """The crossing of the plane (Hearn and Baker 14-62), where it lies inside the sides."""
        plane = self.carrier()
        (distance,) = plane.crossings(ray, on_it, inwards)
        met = jnp.isfinite(distance)
        inside = self._holds_in_plane(plane, ray.at(jnp.where(met, distance, 0)))
        return (jnp.where(met & inside, distance, jnp.inf),)

    def silhouette(self, ray: Ray, footprint: Footprint):
        """Distance in the plane from where the ray meets it to the nearest side, positive inside; and how far that
        is.
        """
        plane = self.carrier()
        distance, _, point, _ = plane.surface(ray, None)
        facing = where(self.side(ray), plane.normal, -plane.normal)
        steps = steps_on_surface(ray, footprint, point, facing)
        inside = jnp.where(self._holds_in_plane(plane, point), 1, -1)
        nearest, outwards = jnp.full(distance.shape, jnp.inf, distance.dtype), plane.normal
        for k in range(self.vertices.x.shape[-1]):
            away, normal = self._from_side(k, plane, point, inside)
            nearest, outwards = where(abs(away) < abs(nearest), (away, normal), (nearest, outwards))
        return Linear(-nearest, *(-dot(outwards, step) for step in steps)), distance

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

    def near_silhouette(self, ray: Ray, reach, growth):
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

    def covers(self, point: Vec3):
        return self._holds_in_plane(self.carrier(), point)

    def bordered(self, ray: Ray, footprint: Footprint):
        return is_cut(self.silhouette(ray, footprint)[0], LEAST_COVERAGE)

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        middle = Vec3(*(c.mean(axis=-1) for c in (self.vertices.x, self.vertices.y, self.vertices.z)))
        away = self.vertices - Vec3(*(c[..., None] for c in (middle.x, middle.y, middle.z)))
        return middle, jnp.sqrt(dot(away, away).max(axis=-1))

    def box(self):
        """The least and the largest corner of a box around each."""
        low, high = (
            Vec3(*(most(c, axis=-1) for c in (self.vertices.x, self.vertices.y, self.vertices.z)))
            for most in (jnp.min, jnp.max)
        )
        return outwards(low, high)

    def _holds_in_plane(self, plane: Planes, point: Vec3):
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


class Polygon(AbstractObject):
    """A plane polygon (a triangle among them) by its vertices, counter-clockwise seen from outside.

    Raises `SceneError` for fewer than three vertices, for no area, and for vertices off the common plane.
    """

    TYPE: ClassVar[str] = "polygon"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("vertices", "vectors", "Metres, counter-clockwise seen from outside.", unit="m", count=(3, None),
            scale="unbounded", moves="rays", freedom="flat"),
    )  # fmt: skip
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {"triangle": (replace(ROWS[0], count=(3, 3)),)}
    FAMILY: ClassVar[type[AbstractSurfaces]] = Polygons
    CONVEX: ClassVar[bool] = True
    FLAT: ClassVar[bool] = True

    vertices: Float[Array, "v 3"]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, vertices, material: str, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        count = entries(vertices)
        if count < 3:
            raise SceneError(f"{place}: vertices has {count} points; allowed is three or more")
        self.vertices = number_array(vertices, place, "vertices", ((count, 3),))
        if not is_traced(self.vertices):
            _check_flat(np.asarray(self.vertices, np.float64), place)

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """Vertices, of which shorter polygons repeat the last."""
        most = max(len(thing.vertices) for thing in objects)
        return [stacked([_padded(thing.vertices, most) for thing in objects])]

    @classmethod
    def family(cls, vertices) -> Polygons:
        return Polygons(vec3(vertices))

    def away_from(self, place: np.ndarray) -> float:
        """From its plane where the foot of the perpendicular is within its sides, else from the nearest side."""
        normal, offset, corners = self.flat()
        along = np.roll(corners, -1, axis=0) - corners
        rise = float(normal @ place) - offset
        foot = place - rise * normal - corners
        share = np.clip((foot * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300), 0, 1)
        from_sides = np.linalg.norm(foot - share[:, None] * along, axis=1).min()
        within = abs(np.sum(_turns(-foot, np.roll(-foot, -1, axis=0), normal))) > np.pi
        return abs(rise) if within else float(np.hypot(rise, from_sides))

    def flat(self) -> tuple[np.ndarray, float, np.ndarray]:
        vertices = np.asarray(self.vertices, np.float64)
        normal = _area(vertices)
        normal = normal / np.linalg.norm(normal)
        return normal, float(normal @ vertices.mean(axis=0)), vertices

    def written_type(self) -> str:
        return "triangle" if len(self.vertices) == 3 else self.TYPE


def _padded(vertices, most: int):
    pad = jnp.pad if is_traced(vertices) else np.pad
    return pad(vertices, ((0, most - len(vertices)), (0, 0)), mode="edge")


def _turns(one: np.ndarray, other: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Angles between vectors (n, 3) of a plane, signed about its normal."""
    return np.arctan2(np.cross(one, other) @ normal, (one * other).sum(axis=1))


def _area(vertices: np.ndarray) -> np.ndarray:
    """Twice the area, as a vector along the outward normal (Newell)."""
    spokes = vertices - vertices[0]
    return np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)


def _check_flat(vertices, place):
    spokes = vertices - vertices[0]
    size = np.abs(spokes).max()
    area = _area(vertices)
    if np.linalg.norm(area) <= 1e-9 * size * size or size == 0:
        raise SceneError(
            f"{place}: vertices span no area (all on one line, or the same point); move one of them off the line"
        )
    away = np.abs(spokes @ (area / np.linalg.norm(area))).max()
    if away > 1e-3 * size:
        raise SceneError(f"{place}: vertices are not in one plane (off by {away:.3g} m); split it into triangles")
