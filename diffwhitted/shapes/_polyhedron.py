"""Bodies with flat faces."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import AbstractSurfaces, Ray
from ..numerics._vector import Vec3, dot, vec3, where
from ..records import Row, entries, is_traced, number_array, read_rows, stacked
from ._object import AbstractObject
from ._plane import Planes
from ._polygon import Polygons

MOST_FACES = 127
"""The number of a face is that of a crossing, a whole number of eight bits."""
SLANT = Vec3(*np.asarray([0.2672612419124244, 0.5345224838248488, 0.8017837257372732]))
"""A direction in which few faces lie."""


class Faces(AbstractSurfaces):
    """The planes that carry the faces of polyhedra, along a trailing axis."""

    normal: Vec3
    offset: Float[Array, "*n faces"]

    def crossings(self, ray: Ray, on_it, inwards):
        """Of no use: a face is known by its number."""
        raise NotImplementedError

    def surface(self, ray: Ray, crossing):
        """That of the plane of the face of this number."""
        assert crossing is not None
        shape = (*ray.origin.shape, self.offset.shape[-1])

        def of_face(column):
            return jnp.take_along_axis(jnp.broadcast_to(column, shape), crossing[..., None], axis=-1)[..., 0]

        normal = Vec3(*(of_face(column) for column in (self.normal.x, self.normal.y, self.normal.z)))
        return Planes(normal, of_face(self.offset)).surface(ray, crossing)


class Polyhedra(AbstractSurfaces):
    """Closed bodies of plane faces, convex or not; the number of a crossing is that of its face.

    `corners` has two trailing axes, of the faces and of their corners: shorter faces repeat their last corner, and
    bodies of fewer faces have faces without area.
    """

    SOLID: ClassVar[bool] = True

    corners: Vec3

    @property
    def crossed_at_most(self) -> int:
        return self.corners.x.shape[-2] * self.count

    def carrier(self) -> Faces:
        """The planes of the faces."""
        planes = Polygons(self.corners).carrier()
        return Faces(planes.normal, planes.offset)

    def surface(self, ray: Ray, crossing):
        """That of the plane of the face."""
        return self.carrier().surface(ray, crossing)

    def crossings(self, ray: Ray, on_it, inwards):
        distances = self._ahead(ray, on_it, inwards)
        return tuple(distances[..., k] for k in range(distances.shape[-1]))

    def first_crossing(self, ray: Ray, on_it, inwards):
        distances = self._ahead(ray, on_it, inwards)
        return distances.min(axis=-1), distances.argmin(axis=-1).astype(jnp.int8)

    def contains(self, point: Vec3):
        """Does a line from there cross the faces an odd number of times?"""
        one = jnp.ones_like(point.x)
        distance, through, _ = self._lines(Ray(point, Vec3(SLANT.x * one, SLANT.y * one, SLANT.z * one)))
        return (through & (distance > 0)).sum(axis=-1) % 2 == 1

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        axes = tuple(c.reshape(*c.shape[:-2], -1) for c in (self.corners.x, self.corners.y, self.corners.z))
        middle = Vec3(*(0.5 * (c.min(axis=-1) + c.max(axis=-1)) for c in axes))
        away = Vec3(*axes) - Vec3(*(c[..., None] for c in (middle.x, middle.y, middle.z)))
        return middle, jnp.sqrt(dot(away, away).max(axis=-1))

    def _ahead(self, ray: Ray, on_it, inwards) -> Float[Array, "*n faces"]:
        """Distances of the faces ahead, infinity for those that are not there.

        A ray goes in and out by turns. So one that starts on the body going in meets nothing by which it would go in
        before a face by which it goes out, and the other way round: the face where it starts is left out by that.
        """
        distance, through, enters = self._lines(ray)
        on_it, inwards = on_it[..., None], jnp.broadcast_to(inwards, on_it.shape)[..., None]
        met = through & (distance > 0)
        turning = enters != inwards
        first = jnp.where(met & turning, distance, jnp.inf).min(axis=-1, keepdims=True)
        # What has just gone in comes out, whatever rounding says.
        behind = jnp.where(through & turning & ~met, distance, -jnp.inf)
        out = on_it & inwards & jnp.isinf(first) & (behind == behind.max(axis=-1, keepdims=True)) & jnp.isfinite(behind)
        ahead = jnp.where(met & (~on_it | turning | (distance > first)), distance, jnp.inf)
        return jnp.where(out, 0, ahead)

    def _lines(self, ray: Ray):
        """For each face: where the line of the ray crosses its plane, whether it does so within the sides, and whether
        it enters there.

        Seen along the ray, corners are points of a plane in which the ray is the origin: an even-odd rule there, whose
        answer to a side is the same for both of its faces, so that no line slips through between them.
        """
        planes = Polygons(self.corners).carrier()
        origin, way = (Vec3(*(c[..., None] for c in (v.x, v.y, v.z))) for v in (ray.origin, ray.direction))
        towards = dot(planes.normal, way)
        level = towards == 0
        distance = (planes.offset - dot(planes.normal, origin)) / jnp.where(level, 1, towards)
        across, along = _square_to(way)
        away = [Vec3(*(c[..., k] for c in (self.corners.x, self.corners.y, self.corners.z))) - origin
                for k in range(self.corners.x.shape[-1])]  # fmt: skip
        seen = [(dot(across, v), dot(along, v)) for v in away]
        inside = jnp.zeros(distance.shape, bool)
        for (u0, v0), (u1, v1) in zip(seen, (*seen[1:], seen[0]), strict=True):
            swap = (v0 > v1) | ((v0 == v1) & (u0 > u1))
            (u0, v0), (u1, v1) = where(swap, ((u1, v1), (u0, v0)), ((u0, v0), (u1, v1)))
            inside ^= ((v0 > 0) != (v1 > 0)) & (u0 * (v1 - v0) > (u1 - u0) * v0)
        return distance, inside & ~level, towards < 0


def _square_to(way: Vec3) -> tuple[Vec3, Vec3]:
    """Two unit vectors square to a unit vector and to each other (Duff et al. 2017, listing 3)."""
    sign = jnp.where(way.z < 0, -1, 1).astype(way.z.dtype)
    a = -1 / (sign + way.z)
    b = way.x * way.y * a
    return Vec3(1 + sign * way.x * way.x * a, sign * b, -sign * way.x), Vec3(b, sign + way.y * way.y * a, -way.y)


class Polyhedron(AbstractObject):
    """A closed body of plane faces: vertices in metres, and faces as the numbers of their corners, from 0.

    The corners of a face run counter-clockwise seen from outside. Raises `SceneError` for a face that is not flat, for
    a side that is not that of two faces, and for a body inside out.
    """

    TYPE: ClassVar[str] = "polyhedron"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("vertices", "vectors", "Metres.", unit="m", count=(4, None), scale="unbounded", moves="rays"),
        Row("faces", "faces", "Numbers of corners, from 0, counter-clockwise seen from outside; flat.",
            count=(4, MOST_FACES)),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Polyhedra

    vertices: Float[Array, "v 3"]
    faces: tuple[tuple[int, ...], ...] = eqx.field(static=True)
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, vertices, faces, material: str, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        read_rows(self, place, faces=faces)
        self.vertices = number_array(vertices, place, "vertices", ((entries(vertices), 3),))
        _check_closed(self.faces, len(self.vertices), place)
        if not is_traced(self.vertices):
            _check_shape(np.asarray(self.vertices, np.float64), self.faces, place)

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """The corners of all faces (faces, corners, 3), padded to the most of each."""
        most = max(len(thing.faces) for thing in objects)
        longest = max(len(face) for thing in objects for face in thing.faces)
        found = []
        for thing in objects:
            faces = [(*face, *[face[-1]] * (longest - len(face))) for face in thing.faces]
            faces += [(0,) * longest] * (most - len(faces))
            found.append(thing.vertices[np.asarray(faces)])
        return [stacked(found)]

    @classmethod
    def family(cls, corners) -> Polyhedra:
        return Polyhedra(vec3(corners))

    def is_convex(self) -> bool:
        """Does no corner lie beyond a face?"""
        if is_traced(self.vertices):
            return False
        vertices = np.asarray(self.vertices, np.float64)
        size = np.ptp(vertices, axis=0).max()
        planes = [_plane(vertices[list(face)]) for face in self.faces]
        return all(((vertices - corner) @ normal <= 1e-6 * size).all() for corner, normal in planes)


def _plane(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A corner and the unit normal (Newell); zero where there is no area."""
    spokes = corners - corners[0]
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    return corners[0], area / (np.linalg.norm(area) or 1.0)


def _check_closed(faces, count: int, place: str) -> None:
    """Raise `SceneError` unless each side belongs to two faces, which run along it in opposite ways."""
    for number, face in enumerate(faces):
        wrong = next((k for k in face if not 0 <= k < count), None)
        if wrong is not None:
            raise SceneError(f"{place}: face {number} has corner {wrong}; allowed is from 0 to {count - 1}")
        if len(set(face)) < len(face):
            raise SceneError(f"{place}: face {number} has a corner twice; allowed is each once")
    sides = Counter(side for face in faces for side in zip(face, (*face[1:], face[0]), strict=True))
    for (a, b), times in sides.items():
        if times > 1:
            raise SceneError(f"{place}: {times} faces run from corner {a} to {b}; allowed is one, and one that runs "
                             "back. Reverse one of them")  # fmt: skip
        if (b, a) not in sides:
            raise SceneError(f"{place}: no face runs from corner {b} to {a}, so it is open there; allowed is a closed "
                             "body. Write single faces as polygons")  # fmt: skip


def _check_shape(vertices: np.ndarray, faces, place: str) -> None:
    """Raise `SceneError` for faces without area or off their plane, and for a body inside out."""
    volume = 0.0
    for number, face in enumerate(faces):
        corners = vertices[list(face)]
        size = np.ptp(corners, axis=0).max()
        corner, normal = _plane(corners)
        if not normal.any():
            raise SceneError(f"{place}: face {number} has no area; take it out, or move a corner")
        off = abs((corners - corner) @ normal).max()
        if off > 1e-3 * size:
            raise SceneError(f"{place}: face {number} is not flat (off by {off:.3g} m); split it into triangles")
        from_first = corners - vertices[0]
        volume += float(from_first[0] @ np.cross(from_first[1:-1], from_first[2:]).sum(axis=0))
    if not volume > 0:
        raise SceneError(f"{place}: faces run clockwise seen from outside; reverse the order of their corners")
