"""Reconstruction filters: how much the light at a place counts for the pixels around it.

The filters of Mitsuba 3, in pixels from the middle of a pixel, both cut off at a radius of 2: the Gaussian of standard
deviation 1/2, lowered so that it ends at 0, and that of Mitchell and Netravali (1988, equation 8) with B = C = 1/3. A
filter of two coordinates is the product of its values in each. A pixel is the mean of all samples of the picture, so
weighed; beyond the edge of the picture there are none.
"""

import numpy as np
from jaxtyping import Float

from ..scene import PixelFilter

RADIUS, DEVIATION = 2.0, 0.5


def filter_weight(kind: PixelFilter, offset: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """The weight of light at so many pixels from the middle, not normalised; 0 beyond the radius."""
    x = np.abs(np.asarray(offset, np.float64))
    if kind == "box":
        return (x < 0.5).astype(np.float64)
    if kind == "gaussian":
        floor = np.exp(-0.5 * (RADIUS / DEVIATION) ** 2)
        return np.maximum(np.exp(-0.5 * (x / DEVIATION) ** 2) - floor, 0)
    b = c = 1 / 3
    near = (12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + (6 - 2 * b)
    far = (-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + (8 * b + 24 * c)
    return np.where(x < 1, near, np.where(x < RADIUS, far, 0)) / 6


def filter_matrix(kind: PixelFilter, count: int, place: float) -> Float[np.ndarray, "count count"]:
    """Along one side of a picture: the weight for pixel i of the sample at `place` (0 to 1) within pixel j."""
    middle = np.arange(count) + 0.5
    return filter_weight(kind, np.arange(count) + place - middle[:, None])


def filtered(
    fine: Float[np.ndarray, "rows columns channels"], side: int, kind: PixelFilter
) -> Float[np.ndarray, "height width channels"]:
    """A picture of side x side points a pixel, taken together to pixels."""
    rows, columns = fine.shape[0] // side, fine.shape[1] // side
    total, weight = np.zeros((rows, columns, fine.shape[2])), np.zeros((rows, columns, 1))
    for down in range(side):
        for across in range(side):
            upright = filter_matrix(kind, rows, (down + 0.5) / side)
            level = filter_matrix(kind, columns, (across + 0.5) / side)
            total += np.einsum("ij,jkc,lk->ilc", upright, fine[down::side, across::side], level, optimize=True)
            weight += np.outer(upright.sum(axis=1), level.sum(axis=1))[..., None]
    return (total / weight).astype(fine.dtype)
