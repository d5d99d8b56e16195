"""What a file says of its colours, and what that means: a curve for each channel, then a matrix to Rec.709.

The first that is there counts: codes of ITU-T H.273 (CICP), an ICC profile, for PNG its sRGB and then its gAMA and
cHRM (PNG, third edition, section 4.3), the chromaticities of an OpenEXR file, the name of a colour space.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import OpenImageIO as oiio
from jaxtyping import Float

from ._encodings import decode_signal, gamma
from ._faults import Unusable
from ._gamut import from_chromaticities, from_space
from ._png import PngColour
from ._profiles import Profile, read_profile

_TRANSFER = {1: "rec709", 4: "gamma:2.2", 5: "gamma:2.8", 6: "rec709", 8: "linear", 13: "srgb", 14: "rec709"}
"""Codes of transfer characteristics (ITU-T H.273, table 3), as far as they are read."""
_PRIMARIES = {1: "ITU-R BT.709", 5: "ITU-R BT.470 - 625", 6: "SMPTE C", 7: "SMPTE C", 9: "ITU-R BT.2020", 12: "P3-D65"}
"""Codes of primaries (ITU-T H.273, table 2), and colour-science's name of a space that has them."""
_SPACES = {
    **dict.fromkeys(("linear", "scene_linear", "lin_rec709", "lin_srgb"), "linear"),
    "srgb": "srgb",
    "rec709": "rec709",
    "kodaklog": "cineon",
}
"""Names of colour spaces with the primaries of Rec.709, as OpenImageIO reports them, in lower case."""
_PREFIXES = {"lin": "linear", "srgb": "srgb", "g18": "gamma:1.8", "g22": "gamma:2.2", "g24": "gamma:2.4"}
"""First words of the names CURVE_PRIMARIES_STATE (ASWF Colour Interop Forum)."""
_INTEROP = {
    "rec709": "ITU-R BT.709",
    "ap0": "ACES2065-1",
    "ap1": "ACEScg",
    "p3d65": "P3-D65",
    "rec2020": "ITU-R BT.2020",
    "adobergb": "Adobe RGB (1998)",
}
"""Words for primaries in these names."""
_SILENT_KINDS = ("pnm", "dpx", "fits")
"""Kinds that hold one encoding as often as another, as files of 16 bits do. OpenImageIO has a guess for the first."""

_WAY_OUT = "say its encoding (such as linear), or convert it first, for instance by oiiotool --colorconvert"


@dataclass(frozen=True, eq=False)
class Decoding:
    """From the numbers of a file to linear Rec.709.

    encoding: its name, or None for a profile's own curves. curves: one for all channels, or three; from float64
    signal, where 1 is the largest code, to light. matrix: from there to Rec.709; None where it is Rec.709.
    """

    encoding: str | None
    curves: tuple[Callable[[np.ndarray], np.ndarray], ...]
    matrix: Float[np.ndarray, "3 3"] | None = None
    notes: tuple[str, ...] = ()


def decoding_of(
    spec: oiio.ImageSpec, kind: str, png: PngColour | None, numbers: np.dtype, wanted: str | None
) -> Decoding:
    """What a file of such numbers says of its colours, `wanted` (an encoding) in place of its curve.

    Raises Unusable for what is stated and not read.
    """
    profile, notes = _profile(spec)
    matrix = None
    if cicp := _cicp(spec):
        encoding = wanted or _TRANSFER.get(cicp[1])
        if encoding is None or (wanted is None and cicp[0] not in _PRIMARIES):
            raise Unusable(f"its colours have the codes {cicp} of ITU-T H.273, which are not read; {_WAY_OUT}")
        matrix = from_space(_PRIMARIES.get(cicp[0], _PRIMARIES[1]))
    elif profile is not None:
        matrix, encoding = profile.matrix, wanted or profile.encoding
        if encoding is None:
            return Decoding(None, profile.curves, matrix, notes)
    elif png is None:
        encoding, matrix = _named(spec, kind, wanted)
    elif png.srgb:
        encoding = wanted or "srgb"
    else:
        encoding = wanted or (None if png.gamma is None else gamma(1 / png.gamma))
        matrix = None if png.chromaticities is None else from_chromaticities(png.chromaticities)
    # Where the file says nothing, go by its numbers.
    if encoding is None:
        encoding = "linear" if np.issubdtype(numbers, np.floating) else "srgb"
        if encoding == "srgb" and (kind in _SILENT_KINDS or numbers == np.uint16):
            notes += ("The file does not say how its numbers stand for light; they were read as sRGB.",)
    return Decoding(encoding, (_curve(encoding),), matrix, notes)


def _curve(encoding: str) -> Callable[[np.ndarray], np.ndarray]:
    return lambda signal: decode_signal(signal, encoding)


def _named(spec: oiio.ImageSpec, kind: str, wanted: str | None) -> tuple[str | None, np.ndarray | None]:
    """Encoding and matrix by the name of a colour space, the chromaticities before it; None for what is not said."""
    tag = spec.get_string_attribute("oiio:ColorSpace").lower()
    if tag in ("", "unknown") or kind == "pnm":
        encoding, matrix = wanted, None
    elif tag in _SPACES:
        encoding, matrix = wanted or _SPACES[tag], None
    else:
        encoding, matrix = _of_space(tag, spec.get_float_attribute("oiio:Gamma"), wanted)
    chromaticities = spec.getattribute("chromaticities")
    return encoding, matrix if chromaticities is None else from_chromaticities(chromaticities)


def _of_space(tag: str, exponent: float, wanted: str | None) -> tuple[str, np.ndarray | None]:
    """Encoding and matrix of a space CURVE_PRIMARIES_STATE; with `wanted`, a name that is not known is no matter.

    exponent: of a power, to more digits than in its name; 0 where the file does not say.
    """
    prefix, _, primaries = tag.rpartition("_")[0].partition("_")
    power = gamma(round(exponent, 5)) if exponent > 0 and prefix[1:].isdigit() else None
    encoding = wanted or power or _PREFIXES.get(prefix)
    if encoding is None or (wanted is None and primaries not in _INTEROP):
        raise Unusable(f"its colour space is {tag!r}, which is not read; {_WAY_OUT}")
    return encoding, from_space(_INTEROP[primaries]) if primaries in _INTEROP else None


def _cicp(spec: oiio.ImageSpec) -> tuple[int, int] | None:
    """Codes of primaries and curve; None where the file states none, or leaves them open (code 2)."""
    codes = spec.getattribute("CICP")
    if codes is None or len(codes) < 2 or 2 in codes[:2]:
        return None
    return int(codes[0]), int(codes[1])


def _profile(spec: oiio.ImageSpec) -> tuple[Profile | None, tuple[str, ...]]:
    """The ICC profile of the file, and a note where there is one that is not read."""
    data = spec.getattribute("ICCProfile")
    if data is None:
        return None, ()
    profile = read_profile(np.asarray(data, np.uint8).tobytes())
    if profile is not None:
        return profile, ()
    name = spec.get_string_attribute("ICCProfile:profile_description")
    if "srgb" in name.lower():
        return None, ()
    return None, (f"The embedded colour profile {name!r} was not applied.",)
