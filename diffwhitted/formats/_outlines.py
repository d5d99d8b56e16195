"""Frames and triangles of what is flat."""

import numpy as np


def frame(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors square to a unit normal and to each other; with it they are right-handed."""
    aside = np.eye(3)[np.argmin(abs(normal))]
    across = np.cross(aside, normal)
    across /= np.linalg.norm(across)
    return across, np.cross(normal, across)


def triangulated(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Triangles (n - 2, 3) of a plane polygon without crossings: ears are cut off one by one."""
    flat = points @ np.stack(frame(normal)).T
    left, triangles = list(range(len(points))), []
    while len(left) > 3:
        place = next((k for k in range(len(left)) if _is_ear(flat, left, k)), 0)
        triangles.append([left[place - 1], left[place], left[(place + 1) % len(left)]])
        del left[place]
    return np.asarray([*triangles, left])


def _is_ear(flat: np.ndarray, left: list[int], place: int) -> bool:
    corners = [left[place - 1], left[place], left[(place + 1) % len(left)]]
    a, b, c = flat[corners]
    others = flat[[k for k in left if k not in corners]]
    # A corner that turns outwards, and nothing of the rest in its triangle.
    sides = [_turn(p, q, others) for p, q in ((a, b), (b, c), (c, a))]
    return _turn(a, b, c) > 0 and not np.all([side >= 0 for side in sides], axis=0).any()


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray):
    """Twice the area of the triangle, positive counter-clockwise."""
    return (b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0])
