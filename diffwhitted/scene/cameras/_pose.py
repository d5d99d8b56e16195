"""Poses: where a camera stands as a matrix of 4 x 4, camera to world."""

import numpy as np

from ..._errors import SceneError
from ...records import is_traced, listed, nearest_name, number_array

AXES: dict[str, tuple[float, float]] = {"opengl": (-1.0, 1.0), "opencv": (1.0, -1.0)}
"""By convention the signs of the way ahead along the camera's z, and of the way up along its y; x is right in both."""
ORTHONORMAL = 1e-4
"""So far may R^T R be from the identity."""


def view_of(pose, convention: str, place: str, far: float):
    """look_from, look_at and up, (3,) each, of a pose; differentiable.

    A camera further than `far` metres from the origin looks at the point one metre ahead, and so counts as far away;
    others at one as far ahead as the origin, so that float32 keeps the direction.
    """
    if convention not in AXES:
        known = " or ".join(f'"{name}"' for name in AXES)
        guess = nearest_name(convention, AXES) if isinstance(convention, str) else ""
        raise SceneError(f"{place}: convention = {convention!r}; allowed is {known}.{guess}")
    matrix = number_array(pose, place, "pose", ((4, 4),))
    look_from, away = matrix[:3, 3], 1.0
    if not is_traced(matrix):
        matrix = np.asarray(matrix, np.float64)
        _check(matrix, place)
        distance = float(abs(look_from).max())
        away = max(1.0, distance) if distance <= far else 1.0
    # Plus 0: no zero keeps a sign.
    ahead, up = (sign * matrix[:3, axis] + 0.0 for sign, axis in zip(AXES[convention], (2, 1), strict=True))
    return look_from, look_from + away * ahead, up


def _check(matrix: np.ndarray, place: str) -> None:
    rotation, last = matrix[:3, :3], matrix[3]
    if abs(last - [0, 0, 0, 1]).max() > ORTHONORMAL:
        transposed = abs(matrix[:3, 3]).max() <= ORTHONORMAL
        advice = "; it is written by columns: transpose it" if transposed else ""
        raise SceneError(f"{place}: the last row of pose is {listed(last)}; allowed is [0, 0, 0, 1]{advice}")
    off = abs(rotation.T @ rotation - np.eye(3)).max()
    if off > ORTHONORMAL:
        lengths = np.round(np.linalg.norm(rotation, axis=0), 4)
        raise SceneError(
            f"{place}: the rotation of pose, its first 3 x 3 numbers, is not orthonormal: R^T R is off by {off:.2g}, "
            f"allowed is {ORTHONORMAL:g}; its columns have the lengths {listed(lengths)}. "
            "Write more digits, and no scale"
        )
    if np.linalg.det(rotation) < 0:
        raise SceneError(
            f"{place}: the rotation of pose mirrors (its determinant is -1); allowed is one of determinant 1. "
            "Turn the sign of one of its columns, or look which way the axes of its program point"
        )
