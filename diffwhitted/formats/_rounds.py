"""A ball as triangles."""

import numpy as np

RINGS, SECTORS = 32, 64
"""Of a sphere: its largest distance from the ball is 0.5 % of the radius."""


def ball(rings: int = RINGS, sectors: int = SECTORS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A unit sphere about the origin, the axis along y: points and unit normals (n, 3), triangles (m, 3)."""
    polar, azimuth = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, sectors + 1), indexing="ij"
    )
    points = np.stack([np.sin(polar) * np.sin(azimuth), np.cos(polar), np.sin(polar) * np.cos(azimuth)], axis=-1)
    first = (np.arange(rings)[:, None] * (sectors + 1) + np.arange(sectors)).ravel()
    below = first + sectors + 1
    upper = np.stack([first, below, first + 1], axis=-1)[sectors:]
    lower = np.stack([first + 1, below, below + 1], axis=-1)[:-sectors]
    points = points.reshape(-1, 3)
    return points, points, np.concatenate([upper, lower])
