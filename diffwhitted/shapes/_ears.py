"""Plane polygons cut into triangles."""

import numpy as np


def cut_into_triangles(points: np.ndarray) -> np.ndarray:
    """Triangles (n - 2, 3) of a plane polygon (n, 2) without crossings, counter-clockwise: ears are cut off one by
    one.
    """
    left, triangles = list(range(len(points))), []
    while len(left) > 3:
        place = next((k for k in range(len(left)) if _is_ear(points, left, k)), 0)
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
