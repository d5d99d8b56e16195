"""The numbers of an image file as they are stored, all through OpenImageIO; nothing is printed.

Every failure is an `ImageError` of one sentence.
"""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from .._files import not_a_file
from ._channels import Choice, Part, choose_channels
from ._faults import ImageError, Unusable, one_line, utf8
from ._jpeg import Jpeg, jpeg_of
from ._png import PngColour, png_colour
from ._statements import Decoding, decoding_of
from ._windows import MOST_PIXELS, in_display_window, upright

_MOST_PARTS = 1000
_TERMINAL = threading.Lock()
_NO_PICTURES = ("null", "zfile")
"""Kinds that OpenImageIO opens and that hold no light."""
_RAW = frozenset(
    ".3fr .arw .cr2 .cr3 .crw .dcr .dng .erf .fff .iiq .kdc .mef .mos .mrw .nef .nrw .orf .pef .raf .raw .rw2 .rwl "
    ".sr2 .srf .srw .x3f".split()
)
_EXACT = frozenset("bmp cineon dpx fits hdr iff openexr png pnm psd rla sgi softimage targa tiff".split())
"""Kinds that keep the numbers which they are given, but for some compressions."""
_STRAIGHT = ("bmp", "ico")
"""Kinds whose alpha is straight, though OpenImageIO does not say so."""
_LOSSY = ("jpeg", "jp2000", "webp", "lerc", "b44", "b44a", "dwaa", "dwab")


@dataclass(frozen=True, eq=False)
class Stored:
    """Numbers as in the file: colour (height, width, 1 or 3), alpha, and what the file says of them.

    bits: of a code; 0 for floats. half: floats of 16 bits. shared_exponent: as Radiance has it. lossy: codes may not
    be the nearest to what was written.
    """

    colour: np.ndarray
    alpha: np.ndarray | None
    premultiplied: bool
    decoding: Decoding
    exposure: float
    bits: int
    half: bool
    shared_exponent: bool
    lossy: bool
    notes: tuple[str, ...]
    jpeg: Jpeg | None = None
    """How a JPEG of sRGB codes was compressed, where that is known and the picture is as it was written."""


def located(path: str | os.PathLike, layer: str | None) -> tuple[Path, str | None]:
    """Path and layer: `FILE:NAME` is the layer NAME of FILE where there is that file, and none of the whole name."""
    path = Path(path)
    file, colon, name = os.fspath(path).rpartition(":")
    try:
        if layer is None and colon and name and not os.path.lexists(path) and Path(file).is_file():
            return Path(file), name
    except ValueError:
        pass
    return path, layer


def load(path: Path, layer: str | None, encoding: str | None = None) -> Stored:
    """Opens and reads a file; every failure becomes an ImageError."""
    try:
        if path.exists() and not path.is_file():
            kind = not_a_file(path) or "a folder"
            raise ImageError(f"{path}: not a file but {kind}; give an image, such as OpenEXR, TIFF, PNG or JPEG.")
        with path.open("rb") as file:
            start = file.read(4)
        if path.suffix.lower() in _RAW:
            raise ImageError(
                f"{path}: camera raw is not read; develop it linearly, for instance with dcraw -4 -T or rawpy, and "
                "read that TIFF with the encoding linear."
            )
        with nullcontext() if start[:3] in _QUIET else _silent_terminal():
            return _decoded(path, layer, encoding)
    except FileNotFoundError:
        raise ImageError(f"{path}: no such file; check the name and the folder.") from None
    except ImageError:
        raise
    except Unusable as error:
        raise ImageError(f"{path}: {error}.") from None
    except (OSError, ValueError, RuntimeError, MemoryError) as error:
        raise ImageError(f"{path}: cannot be read ({one_line(error)}); check the file, or write it anew.") from None


_QUIET = (b"v/1", b"II*", b"MM\0", b"\xff\xd8\xff", b"#?R")
"""How OpenEXR, TIFF, JPEG and Radiance begin: their readers never write to the terminal."""


def _decoded(path: Path, layer: str | None, encoding: str | None) -> Stored:
    """The numbers of a picture in the file, cut to its display window and turned upright."""
    wish = oiio.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(utf8(path), wish)
    if source is None:
        raise OSError(oiio.geterror() or "of no known kind")
    try:
        kind = source.format_name()
        parts = _parts(source, kind, layer)
        choice = choose_channels(parts, layer)
        values, spec = _numbers(source, kind, choice)
        several = kind != "openexr" and layer is None and source.seek_subimage(1, 0)
        source.geterror()
    finally:
        source.close()
    # Bring them to the display window, upright.
    covered = None
    if kind == "openexr":
        values, covered = in_display_window(values, spec)
    orientation = spec.get_int_attribute("Orientation", 1)
    values = upright(values, orientation)
    covered = None if covered is None else upright(covered, orientation)
    # Find out what the file says of them.
    floating = values.dtype == np.float32
    png = png_colour(path) if kind == "png" else None
    decoding = decoding_of(spec, kind, png, values.dtype, encoding)
    straight = kind in _STRAIGHT or bool(spec.get_int_attribute("oiio:UnassociatedAlpha"))
    return Stored(
        colour=values[..., : len(choice.colour)],
        alpha=covered if choice.alpha is None else values[..., -1],
        premultiplied=kind == "openexr" or (spec.alpha_channel == choice.alpha and not straight),
        decoding=decoding,
        exposure=spec.get_float_attribute("hdr:exposure", 1.0) or 1.0,
        bits=0 if floating else _bits(spec, png, values.dtype.itemsize * 8),
        half=all(spec.channelformat(channel).basetype == oiio.HALF for channel in choice.colour),
        shared_exponent=kind == "hdr",
        lossy=_is_lossy(path, spec, kind, png),
        jpeg=jpeg_of(path) if kind == "jpeg" and orientation == 1 and decoding.matrix is None else None,
        notes=(*decoding.notes, *_notes(parts, choice, several, covered is not None, layer)),
    )


def _numbers(source: oiio.ImageInput, kind: str, choice: Choice) -> tuple[np.ndarray, oiio.ImageSpec]:
    """Colour and alpha of a picture, as uint8, uint16 or float32, and what the file says of it."""
    source.seek_subimage(choice.part, 0)
    spec = source.spec()
    _check(spec, kind)
    picked = choice.colour if choice.alpha is None else (*choice.colour, choice.alpha)
    numbers = {spec.channelformat(channel).basetype for channel in picked}
    if not numbers <= {oiio.UINT8, oiio.UINT16, oiio.HALF, oiio.FLOAT, oiio.DOUBLE}:
        raise Unusable(f"its numbers are of type {spec.format}; allowed are uint8, uint16, half, float and double")
    codes = numbers <= {oiio.UINT8, oiio.UINT16}
    first = min(picked)
    values = source.read_image(choice.part, 0, first, max(picked) + 1, "unknown" if codes else "float")
    if (complaint := source.geterror()) or values is None:
        raise OSError(complaint or "no pixels")
    return values[..., [channel - first for channel in picked]], spec


def _notes(parts: list[Part], choice: Choice, several: bool, partly: bool, layer: str | None) -> Iterator[str]:
    """What a user should know of which pixels were read."""
    if several:
        yield "Of several images in the file, the first was read."
    elif len(parts) > 1 and layer is None:
        yield f"Of the {len(parts)} parts of the file, {parts[choice.part].name!r} was read."
    if partly:
        yield "The data window covers only a part of the image; pixels and alpha are 0 outside it."


def _parts(source: oiio.ImageInput, kind: str, layer: str | None) -> list[Part]:
    """The parts of the file that may be the picture: the first alone, unless parts have names or one is asked for."""
    parts = []
    for index in range(_MOST_PARTS if kind == "openexr" or layer is not None else 1):
        if not source.seek_subimage(index, 0):
            break
        spec = source.spec()
        if index == 0:
            _check(spec, kind)
        names = tuple(spec.channelnames)
        if kind != "openexr" and not {"R", "Y"} & set(names) and 1 <= len(names) <= 4:
            names = {1: ("Y",), 2: ("Y", "A"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}[len(names)]
        parts.append(Part(spec.get_string_attribute("oiio:subimagename"), names))
    source.geterror()
    return parts


def _check(spec: oiio.ImageSpec, kind: str) -> None:
    """Raises ValueError for what is no flat picture of a size that can be held."""
    if kind in _NO_PICTURES:
        raise Unusable(
            f"a file of the kind {kind!r} holds no light; give a picture, such as OpenEXR, TIFF, PNG or JPEG"
        )
    if spec.deep:
        raise Unusable("it is deep, with several samples a pixel; flatten it first, for instance by oiiotool --flatten")
    if spec.depth > 1:
        raise Unusable(f"it is a volume of {spec.depth} slices, not a picture; write one slice to a file")
    if spec.width * spec.height > MOST_PIXELS:
        raise Unusable(f"it has {spec.width} x {spec.height} pixels; allowed are {MOST_PIXELS}")


def _bits(spec: oiio.ImageSpec, png: PngColour | None, most: int) -> int:
    """Bits of a code in the file; OpenImageIO spreads 1 to 7 over 8, and 9 to 15 over 16."""
    bits = spec.get_int_attribute("oiio:BitsPerSample", most) if png is None else png.bits
    return bits if 0 < bits <= most else most


def _is_lossy(path: Path, spec: oiio.ImageSpec, kind: str, png: PngColour | None) -> bool:
    """Were the numbers changed on writing: by compression, or by a list of few colours?"""
    compression = spec.get_string_attribute("compression").partition(":")[0]
    if kind not in _EXACT or compression in _LOSSY[: None if kind == "openexr" else 4]:
        return True
    if kind == "targa":
        with path.open("rb") as file:
            return file.read(3)[2] in (1, 9)
    if kind == "bmp":
        return spec.nchannels > 1 and spec.get_int_attribute("bmp:bitsperpixel", 24) < 24
    return (png is not None and png.palette) or spec.get_int_attribute("tiff:PhotometricInterpretation") == 3


@contextmanager
def _silent_terminal() -> Iterator[None]:
    """Sends file descriptor 2 nowhere: libpng writes its complaints there by itself.

    The lock keeps two readers from restoring each other's silence.
    """
    with _TERMINAL:
        kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, 2)
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            os.close(nowhere)
