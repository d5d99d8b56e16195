"""Colour science of the image room: the sRGB curve and CIE Lab.

All formulas come from the colour-science package. Importing it takes about half a second (it loads
matplotlib and scipy), so it is imported inside the functions that need it: a program that only
reads and writes linear files never pays for it.
"""

import warnings
from typing import Any

import numpy as np
from jaxtyping import Float

PRIMARIES = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
"""x, y of red, green, blue and white: ITU-R BT.709-6, items 1.3 and 1.4."""


def colour_science() -> Any:
    """colour-science, without the warnings it gives about optional packages when first imported."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    return colour


def encode_srgb(linear: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """Linear light to sRGB signal, unclipped.

    V = 12.92 L for L <= 0.0031308, else 1.055 L^(1/2.4) - 0.055
    (IEC 61966-2-1:1999, section 5.2; `colour.models.eotf_inverse_sRGB`).

    linear: any shape, 1 is display white. Returns float64 of the same shape; NaN stays NaN,
    negative light follows the straight part, light above 1 goes on along the curve.
    """
    colour = colour_science()
    with colour.utilities.domain_range_scale("reference"):
        return np.asarray(colour.models.eotf_inverse_sRGB(linear), dtype=np.float64)


def decode_srgb(signal: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """sRGB signal to linear light: the inverse of `encode_srgb`, with the same edges.

    L = V / 12.92 for V <= 0.04045, else ((V + 0.055) / 1.055)^2.4
    (IEC 61966-2-1:1999, section 5.2; `colour.models.eotf_sRGB`).

    signal: any shape, 1 is display white. Returns float64 of the same shape.
    """
    colour = colour_science()
    with colour.utilities.domain_range_scale("reference"):
        return np.asarray(colour.models.eotf_sRGB(signal), dtype=np.float64)


def lab(linear: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
    """Linear Rec.709 to CIE L*a*b* relative to D65 (CIE 15:2004, section 8.2.1).

    linear: (..., 3), 1 is the white to which Lab refers. Returns float64 L* in [0, 100], a*, b*.
    """
    colour = colour_science()
    rec709 = colour.models.RGB_COLOURSPACE_BT709
    with colour.utilities.domain_range_scale("reference"):
        tristimulus = colour.RGB_to_XYZ(linear, rec709)
        return colour.XYZ_to_Lab(tristimulus, rec709.whitepoint)


def lab_difference(lab_a: Float[np.ndarray, "... 3"], lab_b: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "..."]:
    """CIEDE2000 with k_L = k_C = k_H = 1 (Sharma, Wu and Dalal 2005, equations 2 to 22).

    lab_a, lab_b: (..., 3) L*, a*, b*. Returns delta E, of shape (...), not negative.
    """
    colour = colour_science()
    with colour.utilities.domain_range_scale("reference"):
        return np.asarray(colour.difference.delta_E_CIE2000(lab_a, lab_b))
