"""Encodings: how the numbers of a file stand for light, by name. A new one is a line in `ENCODINGS`.

All curves come from the colour-science package, which is imported when the first of them is evaluated.
"""

import numpy as np
from jaxtyping import Float

from .._errors import InputError
from ._colour import colour_science

ENCODINGS = {
    "srgb": "sRGB",  # IEC 61966-2-1:1999, section 5.2
    "rec709": "ITU-R BT.709",  # ITU-R BT.709-6, item 1.2: the curve of a camera, not of a screen
    "cineon": "Cineon",  # Kodak, printing density on a 10 bit scale: codes 95 (black) to 685 (white)
}
"""Our name of each encoding, but for `linear` and `gamma:NUMBER`, and the name that colour-science has for it."""

_GAMMA = "gamma:"


def checked_encoding(encoding: str) -> str:
    """The encoding as we write it ("sRGB" is "srgb", "gamma:1" is "linear"); InputError for what is none."""
    name = encoding.strip().lower()
    if name == "linear" or name in ENCODINGS:
        return name
    if name.startswith(_GAMMA):
        try:
            exponent = float(name.removeprefix(_GAMMA))
        except ValueError:
            exponent = 0.0
        if 0 < exponent < float("inf"):
            return gamma(exponent)
    raise InputError(
        f"encoding = {encoding!r}: allowed are linear, {', '.join(ENCODINGS)} and gamma:NUMBER with a number > 0; "
        "try gamma:2.2"
    )


def gamma(exponent: float) -> str:
    """The encoding whose light is the signal to this power: "gamma:2.2", or "linear" for 1."""
    return "linear" if exponent == 1 else f"{_GAMMA}{exponent:.7g}"


def decode_signal(signal: Float[np.ndarray, "*shape"], encoding: str) -> Float[np.ndarray, "*shape"]:
    """Linear light of the signal of a file: L = D(V).

    signal: any shape; 0 and 1 are the lowest and the highest code of a file of integers. encoding: "linear"
    (L = V), "srgb", "rec709" (the inverse of the camera's curve, ITU-R BT.709-6, item 1.2), "cineon", or "gamma:g"
    (L = V^g, mirrored below 0). Returns float64. Raises InputError for another encoding.
    """
    return _curve(np.asarray(signal, np.float64), checked_encoding(encoding), inverse=True)


def encode_signal(light: Float[np.ndarray, "*shape"], encoding: str) -> Float[np.ndarray, "*shape"]:
    """The signal that stands for linear light: the inverse of `decode_signal`, unclipped and unrounded."""
    return _curve(np.asarray(light, np.float64), checked_encoding(encoding), inverse=False)


def _curve(values: np.ndarray, encoding: str, *, inverse: bool) -> np.ndarray:
    """colour-science's curve of that name, from light to signal, or its inverse."""
    if encoding == "linear":
        return values
    colour = colour_science()
    with colour.utilities.domain_range_scale("reference"):
        if encoding in ENCODINGS:
            curve = colour.cctf_decoding if inverse else colour.cctf_encoding
            return np.asarray(curve(values, ENCODINGS[encoding]), np.float64)
        exponent = float(encoding.removeprefix(_GAMMA))
        return np.asarray(colour.gamma_function(values, exponent if inverse else 1 / exponent, "Mirror"), np.float64)
