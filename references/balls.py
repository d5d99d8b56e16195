"""Balls of triangles: subdivided icosahedra."""

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


def ball(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices on the unit sphere and triangles, 20 * 4**levels of them."""
    vertices, faces = CORNERS, TRIANGLES
    for _ in range(levels):
        sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        keys, number = np.unique(sides[:, 0] * len(vertices) + sides[:, 1], return_inverse=True)
        middles = vertices[np.stack([keys // len(vertices), keys % len(vertices)], axis=1)].mean(axis=1)
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        a, b, c = np.split(len(vertices) + number.ravel(), 3)
        corners = [[faces[:, 0], a, c], [faces[:, 1], b, a], [faces[:, 2], c, b], [a, b, c]]
        faces = np.concatenate([np.stack(three, axis=1) for three in corners])
        vertices = np.concatenate([vertices, middles])
    return vertices, faces
