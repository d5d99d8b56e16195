"""The inverse of a normal matrix."""

import numpy as np


def normal_inverse(gram: np.ndarray, rcond: float, like: np.ndarray | None = None) -> np.ndarray:
    """The pseudo-inverse of J'J, (p, p), taken with the columns of J at length one, or those of `like` where it is
    given.

    `rcond`: directions of a smaller share than this are not determined, and 0 in the inverse.
    """
    length = np.sqrt(np.maximum(np.diagonal(gram if like is None else like), 1e-300))
    scale = np.outer(length, length)
    return np.linalg.pinv(gram / scale, rcond=rcond, hermitian=True) / scale
