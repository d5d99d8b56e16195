"""Meshes, patches and sets of spheres as triangles."""

import numpy as np

from ..scene import Mesh, Patch, SphereSet
from ..shapes import bernstein, mean_normals
from ._numbers import plain
from ._rounds import ball

MANY = 16
"""Of more spheres than this each is made of fewer triangles."""
COARSE = 8, 16
"""Rings and sectors: the largest distance from the ball is 8 % of the radius."""
ALONG = 12
"""Cells along each side of a patch."""
SHORT = 1e-9
"""A side shorter than this share of all is none."""

Triangles = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Points (n, 3), unit normals (n, 3), triangles (m, 3), counter-clockwise seen from outside."""


def mesh(thing: Mesh, middle: np.ndarray, reach: float) -> Triangles:
    """Each triangle has corners of its own where it is flat, as its neighbour has another normal."""
    del middle, reach
    vertices, faces = plain(thing.vertices), np.asarray(thing.faces)
    normals = plain(np.asarray(thing.corner_normals()))
    if thing.shading == "flat":
        return vertices[faces].reshape(-1, 3), normals.reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    at_vertices = np.zeros_like(vertices)
    at_vertices[faces] = normals
    return vertices, at_vertices, faces


def patch(thing: Patch, middle: np.ndarray, reach: float) -> Triangles:
    """A grid over each patch, without the triangles that a side which is one point leaves without an area."""
    del middle, reach
    control = plain(thing.control_points).reshape(-1, 4, 4, 3)
    basis = np.stack(bernstein(np.linspace(0, 1, ALONG + 1))[0], axis=-1)
    points = np.einsum("ai,bj,pijk->pabk", basis, basis, control).reshape(-1, 3)
    row = ALONG + 1
    first = (np.arange(ALONG)[:, None] * row + np.arange(ALONG)).ravel()
    cell = np.stack([first, first + 1, first + row + 1, first, first + row + 1, first + row], axis=-1).reshape(-1, 3)
    triangles = (np.arange(len(control))[:, None, None] * row * row + cell).reshape(-1, 3)
    sides = points[triangles] - points[np.roll(triangles, 1, axis=1)]
    triangles = triangles[(abs(sides).max(axis=2) > SHORT * np.ptp(points, axis=0).max()).all(axis=1)]
    return points, mean_normals(points, triangles), triangles


def sphere_set(thing: SphereSet, middle: np.ndarray, reach: float) -> Triangles:
    """A ball for each of them."""
    del middle, reach
    points, normals, triangles = ball(*(COARSE if thing.surfaces > MANY else ()))
    centres, radii = plain(thing.centres), plain(np.asarray(thing.each_radius()))
    count = len(centres)
    placed = centres[:, None] + points * radii[:, None, None]
    numbered = triangles + len(points) * np.arange(count)[:, None, None]
    return placed.reshape(-1, 3), np.tile(normals, (count, 1)), numbered.reshape(-1, 3)
