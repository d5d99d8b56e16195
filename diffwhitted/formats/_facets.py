"""Boxes, discs, cylinders, cones, tori and polyhedra as triangles."""

import numpy as np

from ..scene import Box, Cone, Cylinder, Disc, Polyhedron, Torus
from ._numbers import plain
from ._outlines import frame, triangulated

AROUND, ALONG = 64, 32
"""So many steps around an axis, and around the tube of a torus: the largest distance is 0.12 and 0.5 % of a radius."""

Mesh = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Points (n, 3), unit normals (n, 3), triangles (m, 3), counter-clockwise seen from outside."""


def box(thing: Box, middle: np.ndarray, reach: float) -> Mesh:
    """Four points for each face, as each has a normal of its own."""
    del middle, reach
    sides, corner = plain(thing.along_sides()), plain(thing.minimum)
    parts = []
    for k in range(3):
        first, second = sides[(k + 1) % 3], sides[(k + 2) % 3]
        normal = np.cross(first, second)
        normal /= np.linalg.norm(normal)
        below = corner + np.stack([first * 0, second, first + second, first])
        above = corner + sides[k] + np.stack([first * 0, first, first + second, second])
        parts += [_face(below, -normal), _face(above, normal)]
    return _together(parts)


def disc(thing: Disc, middle: np.ndarray, reach: float) -> Mesh:
    del middle, reach
    normal, _, _ = thing.flat()
    return _fan(plain(thing.centre), normal, float(plain(thing.radius)))


def frustum(thing: Cylinder | Cone, middle: np.ndarray, reach: float) -> Mesh:
    """The side of a cylinder or a cone, and its caps if it has them."""
    del middle, reach
    base, top = plain(thing.base), plain(thing.top)
    radii = (thing.radius, thing.radius) if isinstance(thing, Cylinder) else (thing.base_radius, thing.top_radius)
    low, high = (float(plain(radius)) for radius in radii)
    axis = (top - base) / np.linalg.norm(top - base)
    ring = _ring(axis)
    slope = (high - low) / np.linalg.norm(top - base)
    normals = (ring - slope * axis) / np.hypot(1, slope)
    points = np.concatenate([base + low * ring, top + high * ring])
    parts = [(points, np.tile(normals, (2, 1)), _grid(2, AROUND + 1))]
    if thing.capped:
        ends = ((base, -axis, low), (top, axis, high))
        parts += [_fan(end, normal, radius) for end, normal, radius in ends if radius > 0]
    points, normals, triangles = _together(parts)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return points, normals, triangles[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0]


def torus(thing: Torus, middle: np.ndarray, reach: float) -> Mesh:
    del middle, reach
    axis = plain(thing.axis) / np.linalg.norm(plain(thing.axis))
    ring, turn = _ring(axis), np.linspace(0, 2 * np.pi, ALONG + 1)[:, None, None]
    normals = np.cos(turn) * ring - np.sin(turn) * axis
    points = plain(thing.centre) + float(plain(thing.major_radius)) * ring + float(plain(thing.minor_radius)) * normals
    return points.reshape(-1, 3), normals.reshape(-1, 3), _grid(ALONG + 1, AROUND + 1)[:, ::-1]


def polyhedron(thing: Polyhedron, middle: np.ndarray, reach: float) -> Mesh:
    """Each face with points of its own."""
    del middle, reach
    vertices, parts = plain(thing.vertices), []
    for face in thing.faces:
        corners = vertices[list(face)]
        normal = np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]).sum(axis=0)
        parts.append(_face(corners, normal / np.linalg.norm(normal)))
    return _together(parts)


def _face(corners: np.ndarray, normal: np.ndarray) -> Mesh:
    return corners, np.tile(normal, (len(corners), 1)), triangulated(corners, normal)


def _fan(centre: np.ndarray, normal: np.ndarray, radius: float) -> Mesh:
    """A disc."""
    rim = centre + radius * _ring(normal)[:-1]
    first = np.arange(AROUND)
    triangles = np.stack([np.zeros_like(first), first + 1, (first + 1) % AROUND + 1], axis=-1)
    return np.concatenate([centre[None], rim]), np.tile(normal, (AROUND + 1, 1)), triangles


def _ring(axis: np.ndarray) -> np.ndarray:
    """Unit vectors square to an axis, counter-clockwise seen from its end, the first one again at the end."""
    across, along = frame(axis)
    turn = np.linspace(0, 2 * np.pi, AROUND + 1)[:, None]
    return np.cos(turn) * across + np.sin(turn) * along


def _grid(rows: int, columns: int) -> np.ndarray:
    """Triangles between rows of points, counter-clockwise where rows run upwards and columns to the right."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    above = first + columns
    lower, upper = (first, first + 1, above + 1), (first, above + 1, above)
    return np.concatenate([np.stack(lower, axis=-1), np.stack(upper, axis=-1)])


def _together(parts: list[Mesh]) -> Mesh:
    counts = np.cumsum([0, *(len(points) for points, _, _ in parts[:-1])])
    points, normals = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    return points, normals, np.concatenate([part[2] + count for part, count in zip(parts, counts, strict=True)])
