"""Checkerboards of texture coordinates as those of places."""

import numpy as np

from ..others._boards import Board, board_of

Corners = tuple[np.ndarray, np.ndarray]
"""Points (n, 3) and texture coordinates (n, 2)."""
NEAR = 1e-5


def board_on(colours: np.ndarray, points: np.ndarray, uvs: np.ndarray, to_uv: np.ndarray) -> Board | None:
    """The board where u and v, moved by `to_uv` (4, 4), have the first colour in their first halves: None unless they
    are linear in the place, and its cells are squares along the axes of the scene.
    """
    uvs = uvs @ to_uv[:2, :2].T + to_uv[:2, 3]
    middle, mean = points.mean(axis=0), uvs.mean(axis=0)
    slopes, *_ = np.linalg.lstsq(points - middle, uvs - mean, rcond=1e-6)
    size = np.ptp(uvs, axis=0).max()
    if not size > 0 or abs((points - middle) @ slopes + mean - uvs).max() > NEAR * size:
        return None
    # Two cells are 1.
    across, up = 2 * slopes.T
    counted = [bool(np.linalg.norm(one) * np.ptp(points, axis=0).max() > NEAR * size) for one in (across, up)]
    start = 2 * mean
    if not any(counted):
        return None
    if not all(counted):
        # Along one axis it is the same all over.
        still = start[counted.index(False)]
        across = (across, up)[counted.index(True)]
        up = np.cross(np.eye(3)[abs(across).argmin()], across)
        colours = colours[::-1] if np.floor(still) % 2 else colours
        start = np.asarray([start[counted.index(True)], 0.0])
    into = np.stack([across, up, np.cross(across, up) / np.linalg.norm(np.cross(across, up))])
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.inv(into)
    matrix[:3, 3] = middle - matrix[:3, :2] @ start
    return board_of(colours, matrix, "xy" if all(counted) else "x")
