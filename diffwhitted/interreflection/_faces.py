"""Faces of objects: what patches are cut from, and the coordinates by which a point finds its place on one.

A plane face has the coordinates of the rectangle around it. A round body, and a box, is seen from its middle through
the six faces of a cube, each a face with two coordinates. On the host, in float64.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from .._errors import SceneError
from ..geometry import Ray
from ..numerics._vector import lookup, vec3
from ..shapes import (
    AbstractObject,
    Box,
    Cone,
    Cylinder,
    Disc,
    Mesh,
    Polygon,
    Polyhedron,
    Quadric,
    Sphere,
    cut_into_triangles,
)
from ._lambert import area_of

AROUND = 48
"""Corners of the polygon in place of a disc; its area is that of the disc."""
AXES = np.eye(3)
SIDES = tuple(
    (sign * AXES[axis], AXES[(axis + (1 if sign > 0 else 2)) % 3], AXES[(axis + (2 if sign > 0 else 1)) % 3])
    for axis in range(3)
    for sign in (1, -1)
)
"""Normal and both ways along each face of the cube, the normal their cross product."""


@dataclass(frozen=True)
class Frame:
    """The cube that a round body fills: |rows @ (x - middle)| <= 1."""

    middle: np.ndarray
    ways: np.ndarray
    """Columns: from the middle to a face."""


@dataclass(frozen=True, eq=False)
class Face:
    """Of one object; x = origin + u along + v across for u, v in [0, 1], of a round body in the space of the cube."""

    object: int
    surface: int
    """Of the object's."""
    slot: int
    """Which face of that surface."""
    origin: np.ndarray
    along: np.ndarray
    across: np.ndarray
    outlines: tuple[np.ndarray, ...]
    """Convex polygons (v, 2) of u and v that it is made of, counter-clockwise seen from outside."""
    frame: Frame | None = None
    thing: AbstractObject | None = None

    @property
    def normal(self) -> np.ndarray:
        """Outward, of a plane face."""
        area = np.cross(self.along, self.across)
        return area / np.linalg.norm(area)

    def lengths(self) -> tuple[float, float]:
        """Metres along and across."""
        if self.frame is None:
            return float(np.linalg.norm(self.along)), float(np.linalg.norm(self.across))
        steps = np.linspace(0, 1, 9)
        half = np.full(9, 0.5)
        found = (self.at(np.stack(uv, axis=-1))[0] for uv in ((steps, half), (half, steps)))
        one, other = (float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) for path in found)
        return one, other

    def area(self) -> float:
        if self.frame is None:
            across = np.linalg.norm(np.cross(self.along, self.across))
            return float(sum(area_of(outline) for outline in self.outlines) * across)
        one, other = self.lengths()
        return one * other

    def at(self, uv: Float[np.ndarray, "n 2"]) -> tuple[np.ndarray, np.ndarray]:
        """Points and outward unit normals there."""
        place = self.origin + uv[:, :1] * self.along + uv[:, 1:] * self.across
        if self.frame is None:
            return place, np.repeat(self.normal[None], len(uv), axis=0)
        return on_surface(self.thing, self.frame, place @ self.frame.ways.T)

    def outwards(self, points: Float[np.ndarray, "n 3"]) -> tuple[np.ndarray, np.ndarray]:
        """Points near the face moved onto it, and the outward unit normals there."""
        if self.frame is None:
            return points, np.repeat(self.normal[None], len(points), axis=0)
        return on_surface(self.thing, self.frame, points - self.frame.middle)


def on_surface(thing: AbstractObject | None, frame: Frame, ways: Float[np.ndarray, "n 3"]):
    """Where rays from the middle of a body along these ways leave it: points and outward unit normals."""
    assert thing is not None
    if isinstance(thing, Box):
        return _on_box(frame, ways)
    ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
    if isinstance(thing, Sphere):
        return frame.middle + float(thing.radius) * ways, ways
    count = len(ways)
    # Fill up to a power of two, so that few shapes are compiled.
    ways = np.pad(ways, ((0, (1 << max(count - 1, 0).bit_length()) - count), (0, 0)), mode="edge")
    with jax.ensure_compile_time_eval():
        point, normal = _leaving(thing.alone(), jnp.asarray(frame.middle, float), jnp.asarray(ways, float))
    return np.asarray(point, np.float64)[:count], np.asarray(normal, np.float64)[:count]


@eqx.filter_jit
def _leaving(family: Any, middle, ways):
    member = lookup(family, jnp.zeros(len(ways), jnp.int32))
    ray, none = Ray(vec3(jnp.broadcast_to(middle, ways.shape)), vec3(ways)), jnp.zeros(len(ways), bool)
    _, crossing = member.first_crossing(ray, none, none)
    _, normal, point, _ = member.surface(ray, crossing)
    return point.stacked(), normal.stacked()


def _on_box(frame: Frame, ways: np.ndarray):
    inverse = np.linalg.inv(frame.ways)
    place = ways @ inverse.T
    axis = abs(place).argmax(axis=1)
    furthest = place[np.arange(len(place)), axis]
    normal = inverse[axis] * np.sign(furthest)[:, None]
    return frame.middle + ways / abs(furthest)[:, None], normal / np.linalg.norm(normal, axis=1, keepdims=True)


def faces_of(thing: AbstractObject, number: int) -> list[Face]:
    """The faces of an object of a scene. Raises `SceneError` for a kind that has none."""
    for kind, cut in KINDS:
        if type(thing) is kind:
            return cut(thing, number)
    known = ", ".join(kind.TYPE for kind, _ in KINDS)
    raise SceneError(
        f"object {thing.name!r}: radiosity has no patches of a {thing.written_type()}; allowed are {known}. Write it "
        "as one of these (diffwhitted convert makes meshes), or leave radiosity out"
    )


def _flat(number: int, surface: int, slot: int, corners: np.ndarray, normal: np.ndarray) -> Face:
    """A plane polygon, in the rectangle along its longest side."""
    sides = np.roll(corners, -1, axis=0) - corners
    along = sides[np.linalg.norm(sides, axis=1).argmax()]
    along = along - normal * (along @ normal)
    along = along / np.linalg.norm(along)
    across = np.cross(normal, along)
    flat = (corners - corners[0]) @ np.stack([along, across], axis=1)
    low, size = flat.min(axis=0), np.ptp(flat, axis=0)
    unit = (flat - low) / size
    keep = np.linalg.norm(unit - np.roll(unit, 1, axis=0), axis=1) > 1e-12
    unit = unit[keep]
    outlines = (unit,) if _is_convex(unit) else tuple(unit[corner] for corner in cut_into_triangles(unit))
    origin = corners[0] + low[0] * along + low[1] * across
    return Face(number, surface, slot, origin, along * size[0], across * size[1], outlines)


def _is_convex(loop: np.ndarray) -> bool:
    side = np.roll(loop, -1, axis=0) - loop
    turned = np.roll(side, -1, axis=0)
    return bool((side[:, 0] * turned[:, 1] - side[:, 1] * turned[:, 0] >= -1e-9).all())


def _polygon(thing: Any, number: int) -> list[Face]:
    normal, _, corners = thing.flat()
    return [_flat(number, 0, 0, corners, normal)]


def _disc(thing: Any, number: int) -> list[Face]:
    normal, _, corners = thing.flat()
    centre, first = np.asarray(thing.centre, np.float64), corners[0]
    turn = 2 * np.pi * np.arange(AROUND)[:, None] / AROUND
    grown = np.sqrt(np.pi / (0.5 * AROUND * np.sin(2 * np.pi / AROUND)))
    spoke = (first - centre) * grown
    return [_flat(number, 0, 0, centre + np.cos(turn) * spoke + np.sin(turn) * np.cross(normal, spoke), normal)]


def _mesh(thing: Any, number: int) -> list[Face]:
    corners = np.asarray(thing.vertices, np.float64)[np.asarray(thing.faces)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return [_flat(number, k, 0, corners[k], normals[k]) for k in range(len(corners))]


def _polyhedron(thing: Any, number: int) -> list[Face]:
    found = []
    for slot, face in enumerate(thing.faces):
        corners = np.asarray(thing.vertices, np.float64)[list(face)]
        spokes = corners - corners[0]
        normal = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
        found.append(_flat(number, 0, slot, corners, normal / np.linalg.norm(normal)))
    return found


def _in_cube(frame: Callable[[Any], Frame]) -> Callable[[Any, int], list[Face]]:
    """Faces by a cube around the body; `SceneError` where its middle is not within it."""

    def cut(thing: Any, number: int) -> list[Face]:
        if not np.isfinite(thing.ball()[1]):
            raise SceneError(f"object {thing.name!r}: radiosity has patches of what has an end only; give it ends")
        fitted = frame(thing)
        if not (isinstance(thing, Box) or thing.holds(fitted.middle)):
            raise SceneError(
                f"object {thing.name!r}: radiosity has patches of a {thing.TYPE} that is closed and seen whole from "
                "its middle only; write it as a mesh (diffwhitted convert makes meshes)"
            )
        unit = np.asarray([[0.0, 0.0], [1, 0], [1, 1], [0, 1]])
        return [
            Face(number, 0, k, out - one - other, 2 * one, 2 * other, (unit,), fitted, thing)
            for k, (out, one, other) in enumerate(SIDES)
        ]

    return cut


def _box_frame(thing: Any) -> Frame:
    sides = np.asarray(thing.along_sides(), np.float64)
    ways = sides.T / 2
    if np.linalg.det(ways) < 0:
        ways = -ways
    return Frame(np.asarray(thing.minimum, np.float64) + sides.sum(axis=0) / 2, ways)


def _ball_frame(thing: Any) -> Frame:
    middle, radius = thing.ball()
    return Frame(middle, radius * np.eye(3))


def _axis_frame(thing: Any) -> Frame:
    base, top = np.asarray(thing.base, np.float64), np.asarray(thing.top, np.float64)
    radius = max(
        float(getattr(thing, name)) for name in ("radius", "base_radius", "top_radius") if hasattr(thing, name)
    )
    axis = (top - base) / 2
    way = axis / np.linalg.norm(axis)
    across = np.cross(AXES[abs(way).argmin()], way)
    across = across / np.linalg.norm(across)
    ways = np.stack([radius * np.cross(way, across), radius * across, -axis], axis=1)
    return Frame((base + top) / 2, ways if np.linalg.det(ways) > 0 else ways * [1, 1, -1])


KINDS: Sequence[tuple[type[AbstractObject], Callable[[Any, int], list[Face]]]] = (
    (Polygon, _polygon),
    (Disc, _disc),
    (Mesh, _mesh),
    (Polyhedron, _polyhedron),
    (Box, _in_cube(_box_frame)),
    (Sphere, _in_cube(_ball_frame)),
    (Cylinder, _in_cube(_axis_frame)),
    (Cone, _in_cube(_axis_frame)),
    (Quadric, _in_cube(_ball_frame)),
)
"""The kinds that have patches. A new one is a function here."""
