"""What the chunks of a PNG say of its colours (PNG, third edition, section 11.3.2): OpenImageIO does not tell all."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

_BEFORE_PIXELS = 1000
"""Chunks looked at, at most."""
_LONGEST = 2**12


class PngColour(NamedTuple):
    """Chunks of colour before the pixels.

    srgb: there is one. gamma: gAMA / 100000. chromaticities: x, y of red, green, blue and white, by cHRM.
    bits: of a sample. palette: the pixels are indices into a list of colours.
    """

    srgb: bool = False
    gamma: float | None = None
    chromaticities: tuple[float, ...] | None = None
    bits: int = 8
    palette: bool = False


def png_colour(path: Path) -> PngColour:
    """What the PNG says; a chunk that is too short is as if it were not there."""
    found = PngColour()
    for kind, data in _chunks(path):
        if kind == b"IHDR" and len(data) >= 10:
            found = found._replace(bits=data[8], palette=data[9] == 3)
        elif kind == b"sRGB":
            found = found._replace(srgb=True)
        elif kind == b"gAMA" and len(data) >= 4 and any(data[:4]):
            found = found._replace(gamma=struct.unpack_from(">I", data)[0] / 100_000)
        elif kind == b"cHRM" and len(data) >= 32:
            white_x, white_y, *primaries = (number / 100_000 for number in struct.unpack_from(">8I", data))
            found = found._replace(chromaticities=(*primaries, white_x, white_y))
    return found


def _chunks(path: Path) -> Iterator[tuple[bytes, bytes]]:
    """Kind and first bytes of each chunk before the pixels."""
    with path.open("rb") as file:
        file.seek(8)
        for _ in range(_BEFORE_PIXELS):
            head = file.read(8)
            if len(head) < 8:
                return
            length, kind = struct.unpack(">I4s", head)
            if kind in (b"IDAT", b"IEND"):
                return
            data = file.read(min(length, _LONGEST))
            file.seek(length - len(data) + 4, 1)
            yield kind, data
