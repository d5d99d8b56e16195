"""Frames and triangles of what is flat."""

import numpy as np

from ..shapes import cut_into_triangles


def frame(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors square to a unit normal and to each other; with it they are right-handed."""
    aside = np.eye(3)[np.argmin(abs(normal))]
    across = np.cross(aside, normal)
    across /= np.linalg.norm(across)
    return across, np.cross(normal, across)


def triangulated(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Triangles (n - 2, 3) of a plane polygon (n, 3) without crossings, counter-clockwise about its normal."""
    return cut_into_triangles(points @ np.stack(frame(normal)).T)
