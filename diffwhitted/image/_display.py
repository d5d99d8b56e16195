"""The display transform: scene-referred linear Rec.709 to the numbers of a screen, and back.

Rendered images have no upper end. The only place where they are clipped is here, after the exposure
and before the sRGB curve; `count_clipped` says how many pixels that concerns.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, UInt

from ._colour import decode_srgb, encode_srgb, lab, lab_difference

# Light above 1 (or below 0) by less than this is rounding of float32, not clipping.
_ROUNDING = 1e-6
_LARGEST_EXPOSURE = 64.0


class ClippedPixels(NamedTuple):
    """How many pixels the display cannot show.

    below: pixels with a negative channel; above: pixels with a channel over 1 after exposure. A pixel
    may be in both. Pixels that are not a number are in neither; infinite ones are.
    """

    below: int
    above: int


def encode_for_display(pixels: Float[np.ndarray, "*shape"], *, exposure: float = 0.0) -> Float[np.ndarray, "*shape"]:
    """The display transform: V = sRGB(clip(2^exposure L, 0, 1)).

    pixels: any shape, linear Rec.709, scene-referred. exposure: stops, in [-64, 64]; +1 doubles the light.
    Returns float64 in [0, 1]; NaN stays NaN, infinity becomes 1 (or 0). The curve is
    IEC 61966-2-1:1999 through colour-science. No gradient passes: this is numpy.

    Raises ValueError for an exposure outside its interval, TypeError for pixels that are not floats.
    """
    return encode_srgb(_clipped(pixels, exposure))


def display_codes(
    pixels: Float[np.ndarray, "*shape"], bits: int, *, exposure: float = 0.0
) -> UInt[np.ndarray, "*shape"]:
    """The display transform rounded to the nearest of 2^bits codes; bits is 8 or 16.

    pixels: finite, as in `encode_for_display`. Returns uint8 or uint16 of the same shape.
    """
    dtype = {8: np.uint8, 16: np.uint16}[bits]
    return np.rint(encode_for_display(pixels, exposure=exposure) * np.iinfo(dtype).max).astype(dtype)


def decode_from_display(codes: UInt[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """8 or 16 bit sRGB codes to linear Rec.709: the inverse of `display_codes` at exposure 0.

    codes: uint8 or uint16, any shape. Returns float32 in [0, 1]. Raises TypeError for other types.
    """
    codes = np.asarray(codes)
    if codes.dtype not in (np.uint8, np.uint16):
        raise TypeError(f"display codes are uint8 or uint16, not {codes.dtype}; give the codes as stored in the file")
    largest = np.iinfo(codes.dtype).max
    table = decode_srgb(np.arange(largest + 1) / largest)
    return table.astype(np.float32)[codes]


def count_clipped(pixels: Float[np.ndarray, "*grid 3"], *, exposure: float = 0.0) -> ClippedPixels:
    """How many pixels `encode_for_display` clips at this exposure.

    pixels: (..., 3), linear Rec.709. Light outside [0, 1] by at most 1e-6 counts as rounding.
    """
    exposed = _exposed(pixels, exposure)
    return ClippedPixels(
        below=int(np.any(exposed < -_ROUNDING, axis=-1).sum()),
        above=int(np.any(exposed > 1 + _ROUNDING, axis=-1).sum()),
    )


def ciede2000(
    image_a: Float[np.ndarray, "height width 3"], image_b: Float[np.ndarray, "height width 3"], *, exposure: float = 0.0
) -> Float[np.ndarray, "height width"]:
    """The visible difference of two images: a map of CIEDE2000.

    Both images are exposed and clipped to [0, 1] exactly as `encode_for_display` does, so the map
    compares what a screen would show: two highlights that both clip differ by 0 however unlike
    their radiance. Lower the exposure to compare highlights. Then linear Rec.709 to XYZ to
    CIE L*a*b* (D65) to CIEDE2000 (Sharma, Wu and Dalal 2005), all through colour-science.

    image_a, image_b: (height, width, 3), linear Rec.709. exposure: stops.
    Returns delta E of shape (height, width), float64, 0 where equal, 100 between black and
    white, about 1 where just noticeable, NaN where either image is NaN.

    Raises ValueError when the shapes differ or are not (height, width, 3).
    """
    a, b = _clipped(image_a, exposure), _clipped(image_b, exposure)
    if a.shape != b.shape or a.ndim != 3 or a.shape[-1] != 3:
        raise ValueError(f"ciede2000 compares two images of one shape (height, width, 3), not {a.shape} and {b.shape}")
    return lab_difference(lab(a), lab(b))


def check_exposure(exposure: float) -> None:
    """Raises ValueError for an exposure outside its interval."""
    if not abs(exposure) <= _LARGEST_EXPOSURE:
        limit = _LARGEST_EXPOSURE
        raise ValueError(f"exposure = {exposure}: allowed are {-limit:g} to {limit:g} stops; try 0")


def _exposed(pixels: np.ndarray, exposure: float) -> Float[np.ndarray, "..."]:
    """2^exposure times the pixels, in float64."""
    pixels = np.asarray(pixels)
    if not np.issubdtype(pixels.dtype, np.floating):
        raise TypeError(f"pixels are floats of linear light, not {pixels.dtype}; try decode_from_display first")
    check_exposure(exposure)
    return pixels.astype(np.float64) * 2.0**exposure


def _clipped(pixels: np.ndarray, exposure: float) -> Float[np.ndarray, "..."]:
    """The light that a display shows: exposed, then clipped to [0, 1]."""
    return np.clip(_exposed(pixels, exposure), 0.0, 1.0)
