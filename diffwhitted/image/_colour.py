"""Colour science of the image room: the sRGB curve, CIE Lab, and what a file says of its colours.

All formulas come from the colour-science package. Importing it takes about half a second (it loads
matplotlib and scipy), so it is imported inside the functions that need it: a program that only
reads and writes linear files never pays for it.
"""

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

LINEAR = "linear Rec.709"
SRGB = "sRGB"
PRIMARIES = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)  # ITU-R BT.709-6, items 1.3 and 1.4

# Names of colour spaces as OpenImageIO reports them, in lower case. A PNG that states only a gamma
# of 1/2.2 is what writers of sRGB put for old readers, so it is read with the sRGB curve.
_CURVES = {
    **dict.fromkeys(("lin_rec709_scene", "lin_rec709", "lin_srgb", "linear", "scene_linear"), LINEAR),
    **dict.fromkeys(("srgb_rec709_scene", "srgb_rec709_display", "srgb"), SRGB),
    **dict.fromkeys(("g22_rec709_scene", "g22_rec709_display"), SRGB),
}
_LETTERS = {"red": "r", "green": "g", "blue": "b", "alpha": "a"}


def _colour_science() -> Any:
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
    colour = _colour_science()
    with colour.utilities.domain_range_scale("reference"):
        return np.asarray(colour.models.eotf_inverse_sRGB(linear), dtype=np.float64)


def decode_srgb(signal: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """sRGB signal to linear light: the inverse of `encode_srgb`, with the same edges.

    L = V / 12.92 for V <= 0.04045, else ((V + 0.055) / 1.055)^2.4
    (IEC 61966-2-1:1999, section 5.2; `colour.models.eotf_sRGB`).

    signal: any shape, 1 is display white. Returns float64 of the same shape.
    """
    colour = _colour_science()
    with colour.utilities.domain_range_scale("reference"):
        return np.asarray(colour.models.eotf_sRGB(signal), dtype=np.float64)


def lab(linear: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
    """Linear Rec.709 to CIE L*a*b* relative to D65 (CIE 15:2004, section 8.2.1).

    linear: (..., 3), 1 is the white to which Lab refers. Returns float64 L* in [0, 100], a*, b*.
    """
    colour = _colour_science()
    rec709 = colour.models.RGB_COLOURSPACE_BT709
    with colour.utilities.domain_range_scale("reference"):
        tristimulus = colour.RGB_to_XYZ(linear, rec709)
        return colour.XYZ_to_Lab(tristimulus, rec709.whitepoint)


def lab_difference(lab_a: Float[np.ndarray, "... 3"], lab_b: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "..."]:
    """CIEDE2000 with k_L = k_C = k_H = 1 (Sharma, Wu and Dalal 2005, equations 2 to 22).

    lab_a, lab_b: (..., 3) L*, a*, b*. Returns delta E, of shape (...), not negative.
    """
    colour = _colour_science()
    with colour.utilities.domain_range_scale("reference"):
        return np.asarray(colour.difference.delta_E_CIE2000(lab_a, lab_b))


def curve_of(tag: str, floating: bool) -> str:
    """Which curve the numbers of a file follow: `LINEAR` or `SRGB`.

    tag: the colour space that the file states, "" where it states none; then float numbers are
    linear and whole numbers sRGB. Raises ValueError for a space that is neither, since reading it
    as one of them would give wrong coefficients without a word.
    """
    if tag.lower() in ("", "unknown"):
        return LINEAR if floating else SRGB
    if tag.lower() not in _CURVES:
        raise ValueError(f"its colour space is {tag!r}, and only linear Rec.709 and sRGB are read")
    return _CURVES[tag.lower()]


def pick_channels(names: Sequence[str], layer: str | None, by_name: bool) -> tuple[list[int], int | None]:
    """Which channels of a file are its colour (three, or one of grey) and which is its alpha.

    names: as in the file. by_name: names mean something (OpenEXR: "R", or "layer.R"); else the order
    does. Raises ValueError when there is no colour, or several layers and no word on which.
    """
    if not by_name:
        if layer is not None or not 1 <= len(names) <= 4:
            raise ValueError(f"it has {len(names)} channels without layers; allowed are 1 to 4, and layer = None")
        colour = [0, 1, 2] if len(names) >= 3 else [0]
        return colour, None if len(names) in (1, 3) else len(names) - 1
    layers: dict[str, dict[str, int]] = {}
    for index, name in enumerate(names):
        prefix, _, channel = name.rpartition(".")
        layers.setdefault(prefix, {})[_LETTERS.get(channel.lower(), channel.lower())] = index
    found = {prefix: [c[letter] for letter in "rgb"] for prefix, c in layers.items() if {"r", "g", "b"} <= c.keys()}
    found |= {prefix: [c["y"]] for prefix, c in layers.items() if "y" in c and not {"r", "ry", "by"} & c.keys()}
    if len(names) == 1:
        found = {next(iter(layers)): [0]}
    if layer is None and ("" in found or len(found) == 1):
        layer = "" if "" in found else next(iter(found))
    if layer not in found:
        problem = "has several layers, none asked for" if layer is None and found else "has no R, G, B or Y there"
        remedy = f"; ask for the layer {' or '.join(sorted(map(repr, found)))}" if found else ""
        raise ValueError(f"it {problem}; its channels are {', '.join(names)}{remedy}")
    return found[layer], layers[layer].get("a") if len(names) > 1 else None
