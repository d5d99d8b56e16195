"""Meshes for tests: balls, smooth and bumpy, and boxes."""

import numpy as np

from references.balls import ball

__all__ = ["BOX", "BOX_FACES", "ball", "bumpy"]

BOX = np.asarray([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
BOX_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
"""Of a cube from -1 to 1, counter-clockwise seen from outside."""


def bumpy(levels: int, height: float = 0.04) -> tuple[np.ndarray, np.ndarray]:
    """The same with bumps."""
    vertices, faces = ball(levels)
    x, y, z = vertices.T
    return vertices * (1 + height * np.sin(7 * x) * np.sin(6 * y + 1) * np.sin(8 * z + 2))[:, None], faces
