"""Balls: the sphere flake."""

from math import asin, pi, sqrt

import numpy as np

from ..scene import Polygon, SphereSet
from ._parts import THREE_AROUND, Parts, Y, Z, paint, turned, usual_camera, usual_scene

ROOT_RADIUS = 0.5
LIGHTS = ((4, 3, 2), (1, -4, 4), (-3, 1, 5))
UPSIDE_DOWN = 1e-4
"""A direction nearer than this to -z has no axis of its own by which to turn to it."""


def balls(size: int) -> Parts:
    """Spheres on spheres: (9^(size + 1) - 1) / 8 of them, over a floor."""
    corners = [[12, 12, -0.5], [-12, 12, -0.5], [-12, -12, -0.5], [12, -12, -0.5]]
    return usual_scene(
        [SphereSet("flake", *flake(size), "flake"), Polygon("floor", corners, "floor")],
        {"flake": paint((1, 0.9, 0.7), 0.5, 0.5, 37), "floor": paint((1, 0.75, 0.33), 0.8)},
        LIGHTS,
        usual_camera((2.1, 1.3, 1.7), (0, 0, 0)),
    )


def flake(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3) and radii (n,), the root first.

    Each sphere has nine children a third as large that touch it, in the directions of `around_z` as seen from its own.
    """
    centre, direction, radius = np.zeros((1, 3)), Z[None], ROOT_RADIUS
    centres, radii = [centre], [np.full(1, radius)]
    for _ in range(size):
        ways = np.einsum("cj,njk->nck", around_z(), _from_z_to(direction)).reshape(-1, 3)
        centre = np.repeat(centre, 9, axis=0) + ways * radius * (1 + 1 / 3)
        direction, radius = ways, radius / 3
        centres, radii = [*centres, centre], [*radii, np.full(len(centre), radius)]
    return np.concatenate(centres), np.concatenate(radii)


def around_z() -> np.ndarray:
    """Nine unit directions (9, 3), three around +z and six about its equator."""
    three = np.asarray([[1, 1, 0], [1, 0, -1], [0, 1, -1]]) / sqrt(2)
    three = three @ turned((1, -1, 0), asin(2 / sqrt(6)))
    return np.concatenate([three @ turned(Z, angle) for angle in THREE_AROUND])


def _from_z_to(directions: np.ndarray) -> np.ndarray:
    """Matrices (n, 3, 3) that turn row vectors by the least angle that takes +z to each direction."""
    matrices = np.empty((len(directions), 3, 3))
    for k, way in enumerate(directions):
        axis = np.cross(Z, way)
        if way[2] < 0 and np.linalg.norm(axis) < UPSIDE_DOWN:
            matrices[k] = turned(Y, pi)
        elif not axis.any():
            matrices[k] = np.eye(3)
        else:
            matrices[k] = turned(axis, np.arctan2(np.linalg.norm(axis), way[2]))
    return matrices
