"""JPEG: how a file was compressed, and what the same compression makes of another picture.

A JPEG keeps brightness and colour apart, colour often at half the resolution, and of both the cosine coefficients of
blocks of 8 x 8, rounded to multiples of the numbers in its tables (ITU-T T.81, sections B.2 and K.1). Programs by the
Independent JPEG Group's library scale the tables of K.1 by a quality from 1 to 100, which the tables of a file tell.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from jaxtyping import UInt8

_LUMINANCE = np.array([
    16, 11, 12, 14, 12, 10, 16, 14, 13, 14, 18, 17, 16, 19, 24, 40, 26, 24, 22, 22, 24, 49, 35, 37, 29, 40, 58, 51, 61,
    60, 57, 51, 56, 55, 64, 72, 92, 78, 64, 68, 87, 69, 55, 56, 80, 109, 81, 87, 95, 98, 103, 104, 103, 62, 77, 113,
    121, 112, 100, 120, 92, 101, 103, 99,
])  # fmt: skip
"""Table K.1, in the order of a file."""
_SUBSAMPLING = {(2, 2): "4:2:0", (2, 1): "4:2:2", (1, 1): "4:4:4"}
_FRAMES, _SCAN, _TABLES, _ALONE = (0xC0, 0xC1, 0xC2), 0xDA, 0xDB, (0x01, *range(0xD0, 0xD9))


@dataclass(frozen=True)
class Jpeg:
    """How a file was compressed."""

    quality: int
    subsampling: str
    """Of colour: "4:4:4" none, "4:2:2" across, "4:2:0" across and down."""

    def of(self, codes: UInt8[np.ndarray, "height width 3"]) -> UInt8[np.ndarray, "height width 3"]:
        """What is read of a picture that was so written."""
        spec = oiio.ImageSpec(codes.shape[1], codes.shape[0], 3, "uint8")
        spec.attribute("CompressionQuality", self.quality)
        spec.attribute("jpeg:subsampling", self.subsampling)
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder, "picture.jpg"))
            output = oiio.ImageOutput.create(path)
            if output is None or not output.open(path, spec) or not output.write_image(codes) or not output.close():
                raise OSError(oiio.geterror() or "a JPEG cannot be written to the folder of temporary files")
            source = oiio.ImageInput.open(path)
            if source is None:
                raise OSError(oiio.geterror())
            read = source.read_image("uint8")
            source.close()
        return np.asarray(read)


def jpeg_of(path: Path) -> Jpeg | None:
    """How a file was compressed; None for tables of another kind, grey files and odd subsampling."""
    content, place, table, sampling = path.read_bytes(), 2, None, None
    while place + 4 <= len(content) and content[place] == 0xFF:
        kind = content[place + 1]
        if kind == 0xFF or kind in _ALONE:
            place += 1 if kind == 0xFF else 2
            continue
        size = int.from_bytes(content[place + 2 : place + 4], "big")
        part = content[place + 4 : place + 2 + size]
        if kind == _TABLES and table is None and len(part) >= 65 and part[0] == 0:
            table = np.frombuffer(part[1:65], np.uint8).astype(int)
        elif kind in _FRAMES and len(part) >= 15 and part[5] == 3:
            factors = [(part[k] >> 4, part[k] & 15) for k in (7, 10, 13)]
            sampling = _SUBSAMPLING.get(factors[0]) if factors[1] == factors[2] == (1, 1) else None
        elif kind == _SCAN:
            break
        place += 2 + size
    if table is None or sampling is None:
        return None
    qualities = (q for q in range(1, 101) if np.array_equal(table, _scaled(q)))
    quality = next(qualities, None)
    return None if quality is None else Jpeg(quality, sampling)


def _scaled(quality: int) -> np.ndarray:
    """The table of a quality, as the library of the Independent JPEG Group has it."""
    scale = 5000 // quality if quality < 50 else 200 - 2 * quality
    return np.clip((_LUMINANCE * scale + 50) // 100, 1, 255)
