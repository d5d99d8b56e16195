"""The teapot on a checkered floor. Its patches: the Utah teapot (M. Newell) with bottom, as in E. Haines' databases."""

import json
from importlib.resources import files

import numpy as np

from ..scene import Mesh
from ._parts import Parts, paint, usual_camera, usual_scene

LIGHTS = ((-3.1, 9.8, 12.1), (11.3, 5.1, 8.8))
HALF_FLOOR = 4.0
COLLAPSED = 1e-9
"""A normal shorter than this before it is made a unit is none: there a side of the patch is one point."""


def teapot(size: int) -> Parts:
    """32 bicubic patches of size x size cells, two triangles each, over a floor of size x size squares."""
    vertices, normals, faces = pot(size)
    white, grey = floor(size)
    return usual_scene(
        [
            Mesh("pot", vertices, faces, "pot", normals=normals),
            Mesh("white squares", *white, "white"),
            *([Mesh("grey squares", *grey, "grey")] if len(grey[1]) else []),
        ],
        {
            "pot": paint((1, 0.5, 0.1), 0.75, 0.25, 37),
            "white": paint((1, 1, 1), 0.5, 0.5, 30),
            "grey": paint((0.5, 0.5, 0.5), 0.5, 0.5, 30),
        },
        LIGHTS,
        usual_camera((4.86, 7.2, 5.4), (0, 0, 0)),
    )


def control_points() -> np.ndarray:
    """Of the 32 patches, (32, 4, 4, 3), metres, z up."""
    held = json.loads(files("diffwhitted.standard").joinpath("teapot.json").read_text(encoding="utf-8"))
    return np.asarray(held["vertices"], np.float64)[np.asarray(held["patches"])]


def pot(size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (v, 3), outward unit normals (v, 3) and triangles (f, 3); those with two corners in one place are left
    out.
    """
    points, normals = patch_grid(control_points(), np.linspace(0, 1, size + 1))
    row = size + 1
    first = (np.arange(size)[:, None] * row + np.arange(size)).ravel()
    corners = first, first + 1, first + row + 1, first + row
    cell = np.concatenate([np.stack([corners[k] for k in three], axis=-1) for three in ((0, 1, 2), (2, 3, 0))])
    faces = (np.arange(len(points))[:, None, None] * row**2 + cell).reshape(-1, 3)
    vertices, normals = points.reshape(-1, 3), normals.reshape(-1, 3)
    sides = vertices[faces] - vertices[np.roll(faces, 1, axis=1)]
    return vertices, normals, faces[(abs(sides).max(axis=2) > COLLAPSED).all(axis=1)]


def patch_grid(control: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and unit normals (p, n, n, 3) of bicubic Bezier patches at s, t in `at` (n,), s along the first axis.

    The normal is that of dS/dt x dS/ds. Where dS/dt vanishes, as a side of the patch is one point, it is the limit from
    within: that of d2S/dsdt x dS/ds at s = 0.
    """
    basis, slope = _bernstein(at)
    points, along_s, along_t, twist = (
        np.einsum("ai,bj,pijk->pabk", one, other, control)
        for one, other in ((basis, basis), (slope, basis), (basis, slope), (slope, slope))
    )
    normal, limit = np.cross(along_t, along_s), np.cross(twist, along_s)
    gone = np.linalg.norm(normal, axis=-1, keepdims=True) < COLLAPSED
    normal = np.where(gone, limit, normal)
    return points, normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def _bernstein(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The four cubic polynomials and their derivatives at (n,): (n, 4) each."""
    t, u = at, 1 - at
    basis = np.stack([u**3, 3 * t * u**2, 3 * t**2 * u, t**3], axis=-1)
    slope = np.stack([-3 * u**2, 3 * u**2 - 6 * t * u, 6 * t * u - 3 * t**2, 3 * t**2], axis=-1)
    return basis, slope


def floor(size: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Vertices and faces of the squares whose row and column have an odd sum, and of the others; facing upwards."""
    side = 2 * HALF_FLOOR / size
    i, j = (a.ravel() for a in np.meshgrid(np.arange(size), np.arange(size), indexing="ij"))
    corner = np.stack([i * side - HALF_FLOOR, j * side - HALF_FLOOR, 0.0 * i], axis=-1)
    square = side * np.asarray([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    parts = []
    for odd in (1, 0):
        mine = corner[(i + j) % 2 == odd]
        parts.append(((mine[:, None] + square).reshape(-1, 3), np.arange(4 * len(mine)).reshape(-1, 4)))
    return parts
