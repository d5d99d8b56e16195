"""Meshes for tests: subdivided icosahedra, smooth and bumpy, and boxes."""

import numpy as np

GOLDEN = (1 + 5**0.5) / 2
CORNERS = np.asarray([
    [-1, GOLDEN, 0], [1, GOLDEN, 0], [-1, -GOLDEN, 0], [1, -GOLDEN, 0], [0, -1, GOLDEN], [0, 1, GOLDEN],
    [0, -1, -GOLDEN], [0, 1, -GOLDEN], [GOLDEN, 0, -1], [GOLDEN, 0, 1], [-GOLDEN, 0, -1], [-GOLDEN, 0, 1],
]) / np.hypot(1, GOLDEN)  # fmt: skip
TRIANGLES = np.asarray([
    [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6],
    [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7],
    [9, 8, 1],
])  # fmt: skip
BOX = np.asarray([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
BOX_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
"""Of a cube from -1 to 1, counter-clockwise seen from outside."""


def ball(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices on the unit sphere and triangles, 20 * 4**levels of them."""
    vertices, faces = CORNERS, TRIANGLES
    for _ in range(levels):
        sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        once, number = np.unique(sides, axis=0, return_inverse=True)
        middles = vertices[once].mean(axis=1)
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        a, b, c = np.split(len(vertices) + number.ravel(), 3)
        corners = [[faces[:, 0], a, c], [faces[:, 1], b, a], [faces[:, 2], c, b], [a, b, c]]
        faces = np.concatenate([np.stack(three, axis=1) for three in corners])
        vertices = np.concatenate([vertices, middles])
    return vertices, faces


def bumpy(levels: int, height: float = 0.04) -> tuple[np.ndarray, np.ndarray]:
    """The same with bumps."""
    vertices, faces = ball(levels)
    x, y, z = vertices.T
    return vertices * (1 + height * np.sin(7 * x) * np.sin(6 * y + 1) * np.sin(8 * z + 2))[:, None], faces
