"""The picture of a camera: its sides in pixels, and a window in it."""

import numpy as np

from ..._errors import SceneError
from ...records import listed

LARGEST_SIDE = 32768
"""Pixels; a picture of this width and height still numbers its pixels in 32 bits."""
Side = int | float
"""Pixels: a whole number, but of the full picture of a crop that was resized."""


def pixels(value, place: str, field: str) -> int:
    """A checked side of a picture."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 1 <= value <= LARGEST_SIDE:
        raise SceneError(f"{place}: {field} = {value!r}; allowed is a whole number of pixels from 1 to {LARGEST_SIDE}")
    return int(value)


def crop_of(crop, full: tuple[int, int], place: str) -> tuple[int, int, int, int] | None:
    """A checked window in a picture: left, top, width, height."""
    if crop is None:
        return None
    width, height = full
    allowed = f"allowed is [left, top, width, height], whole pixels within the {width} x {height} of the full picture"
    try:
        stated = np.asarray(crop, np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"{place}: crop = {crop!r}; {allowed}") from None
    if stated.shape != (4,) or not np.isfinite(stated).all() or (stated % 1).any():
        raise SceneError(f"{place}: crop = {listed(stated)}; {allowed}")
    left, top, across, down = (int(side) for side in stated)
    if min(left, top) < 0 or min(across, down) < 1 or left + across > width or top + down > height:
        raise SceneError(f"{place}: crop = {listed(stated)}; {allowed}")
    return left, top, across, down


def whole(side: float) -> Side:
    """The same number, as a whole one where it is one."""
    return int(side) if side == int(side) else side
