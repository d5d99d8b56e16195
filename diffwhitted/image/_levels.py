"""Levels of a display that are few: what is asked of a picture, and the nearest level.

A picture is (height, width) or (height, width, 3), linear light in [0, 1]; the levels are evenly spaced in it.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np

from .._errors import InputError
from ..records import is_traced, whole_number

MOST_LEVELS = 65536


def checked(image: Any, levels: int, what: str) -> Any:
    """The picture as an array of floats. Raises `InputError` for a picture, or a number of levels, that is not allowed;
    the values of a traced picture are not looked at.
    """
    whole_number(levels, f"{what}: levels", 2, MOST_LEVELS, InputError)
    shape = np.shape(image)
    if len(shape) not in (2, 3) or shape[2:] not in ((), (3,)) or 0 in shape:
        raise InputError(f"{what}: a picture of shape {shape}; allowed is (height, width) or (height, width, 3)")
    image = image if is_traced(image) else np.asarray(image)
    if not jnp.issubdtype(image.dtype, jnp.floating):
        raise InputError(f"{what}: a picture of {image.dtype}; allowed are floats of linear light")
    if not is_traced(image):
        outside = ~((image >= 0) & (image <= 1))
        if outside.any():
            place = tuple(int(k) for k in np.argwhere(outside)[0][:2])
            raise InputError(
                f"{what}: {int(outside.sum())} values are outside of [0, 1] or not a number, the first in row "
                f"{place[0]}, column {place[1]}: {float(image[outside].ravel()[0]):g}; try fit_range(image) first"
            )
    return jnp.asarray(image)


def nearest(values: Any, levels: int) -> Any:
    """The level nearest to each value, in [0, 1]; of two as near the higher one."""
    return jnp.clip(jnp.floor(values * (levels - 1) + 0.5), 0, levels - 1) / (levels - 1)


def fit_range(image: Any, how: str = "clamp") -> Any:
    """A picture of linear light within [0, 1].

    "clamp" cuts off what is above 1 or below 0; "scale" divides by the largest value of the picture, so that ratios
    stay (a picture without light stays as it is), and cuts off what is below 0. Any shape; the derivative is that of
    this expression. Raises `InputError` for another word.
    """
    image = jnp.asarray(image)
    if how == "scale":
        largest = image.max()
        image = jnp.where(largest > 0, image / jnp.where(largest > 0, largest, 1), image)
    elif how != "clamp":
        raise InputError(f'fit_range: how = {how!r}; allowed is "clamp" or "scale"')
    return jnp.clip(image, 0, 1)
