"""Image files in, all through OpenImageIO.

In memory: linear Rec.709, straight (not premultiplied) alpha, row 0 on top. In the file: whatever the
format holds. Every failure is an `ImageError` of one sentence, and nothing is printed.
"""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from jaxtyping import Bool, Float

from .._files import not_a_file
from ._colour import PRIMARIES, SRGB, curve_of, decode_srgb, pick_channels
from ._display import decode_from_display
from ._faults import ImageError, one_line, refuse, utf8

_KINDS = {"openexr": "OpenEXR", "hdr": "Radiance", "tiff": "TIFF", "png": "PNG", "jpeg": "JPEG"}
_MOST_PIXELS = 2**27  # a broken header may claim any size
_TERMINAL = threading.Lock()


@dataclass(frozen=True, eq=False)
class ImageFile:
    """What an image file holds.

    pixels: (height, width, 3) float32, linear Rec.709, straight alpha; NaN and infinity as stored.
    alpha: (height, width) float32, or None where the file has none. path: where it was read.
    colour_space: of the numbers in the file, "linear Rec.709" or "sRGB".
    notes: what a user should know of how the file was read, a sentence each; mostly empty.
    clipped: (height, width), where a channel of 8 or 16 bit colour has its largest code; None for floats.
    """

    pixels: Float[np.ndarray, "height width 3"]
    alpha: Float[np.ndarray, "height width"] | None
    path: Path
    colour_space: str
    notes: tuple[str, ...] = ()
    clipped: Bool[np.ndarray, "height width"] | None = None


@dataclass(frozen=True, eq=False)
class _Stored:
    """Numbers as in the file: colour (height, width, 1 or 3), alpha, and what the file says of them."""

    colour: np.ndarray
    alpha: np.ndarray | None
    premultiplied: bool
    colour_tag: str
    exposure: float
    notes: tuple[str, ...]


def read_image(path: str | os.PathLike, *, layer: str | None = None) -> ImageFile:
    """Reads an OpenEXR, Radiance, TIFF, PNG or JPEG file as linear Rec.709.

    Whole numbers (8 or 16 bit) are taken as sRGB and floats as linear, unless the file states otherwise.
    Grey becomes three equal channels; two channels are grey and alpha. Channels of an OpenEXR file are
    found by name (R, G, B, A, or Y), in `layer` where there are several. Premultiplied colour (OpenEXR by
    convention, TIFF where it says so) is divided by alpha where alpha > 0 and kept where it is 0. Pixels
    are turned the way the file's orientation says. Where the data window of an OpenEXR file does not
    reach, pixels and alpha are 0; what lies outside its display window is cut off.

    Raises ImageError for a file that is missing, broken, cut short, or of another kind or colour space.
    """
    path = Path(path)
    stored = _load(path, layer)
    colour, alpha = stored.colour, stored.alpha
    floating = colour.dtype == np.float32
    clipped = None if floating else (colour == np.iinfo(colour.dtype).max).any(axis=2)
    try:
        curve = curve_of(stored.colour_tag, floating=floating)
    except ValueError as error:
        raise ImageError(f"{path}: {error}; convert it first, for instance with oiiotool --colorconvert.") from None
    # A file may hold NaN and infinity; they pass through, without warnings.
    with np.errstate(all="ignore"):
        if alpha is not None:
            alpha = _unit(alpha)
            if stored.premultiplied:
                colour, floating = _unit(colour), True
                colour = np.where(alpha[..., None] > 0, colour / alpha[..., None], colour)
        if curve == SRGB:
            colour = decode_srgb(colour) if floating else decode_from_display(colour)
        pixels = _unit(colour) / np.float32(stored.exposure)
    pixels = np.ascontiguousarray(np.broadcast_to(pixels, (*pixels.shape[:2], 3)))
    return ImageFile(pixels, alpha, path, curve, stored.notes, clipped)


def read_mask(path: str | os.PathLike) -> Float[np.ndarray, "height width"]:
    """Reads a mask: (height, width) float32 in [0, 1], the numbers of the file with no colour transform.

    8 and 16 bit codes are divided by 255 and 65535. The file is grey, or colour with equal channels. With
    alpha, the mask is grey over black, so transparent counts as 0.

    Raises ImageError as `read_image` does, and for unequal channels, NaN, and values outside [0, 1].
    """
    path = Path(path)
    stored = _load(path, None)
    colour = _unit(stored.colour)
    mask = colour[..., 0]
    if not np.allclose(colour, mask[..., None], rtol=0, atol=1e-3, equal_nan=True):
        raise ImageError(f"{path}: a mask is grey, and the channels of this file differ; save it as greyscale.")
    if stored.alpha is not None and not stored.premultiplied:
        mask = mask * _unit(stored.alpha)
    bad = ~((mask >= -1e-4) & (mask <= 1.0001))
    refuse(path, bad, "are outside [0, 1] or not a number; a mask is 1 where a pixel counts")
    return np.clip(mask, 0, 1)


def _load(path: Path, layer: str | None) -> _Stored:
    """Opens and reads a file; every failure becomes an ImageError."""
    try:
        if path.exists() and not path.is_file():
            kind = not_a_file(path) or "a folder"
            raise ImageError(
                f"{path}: not a file but {kind}; give an image in one of the formats {', '.join(_KINDS.values())}."
            )
        with path.open("rb") as file:
            png = file.read(4) == b"\x89PNG"
        with _silent_terminal() if png else nullcontext():
            return _decoded(path, layer)
    except FileNotFoundError:
        raise ImageError(f"{path}: no such file; check the name and the folder.") from None
    except ImageError:
        raise
    except (OSError, ValueError, RuntimeError, MemoryError) as error:
        raise ImageError(f"{path}: cannot be read ({one_line(error)}); check the file, or write it anew.") from None


def _decoded(path: Path, layer: str | None) -> _Stored:
    """The numbers of the first image in the file, cut to its display window and turned upright."""
    wish = oiio.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(utf8(path), wish)
    if source is None:
        raise OSError(oiio.geterror() or "of no known kind")
    try:
        spec, kind = source.spec(), source.format_name()
        if kind not in _KINDS or spec.deep or spec.depth > 1:
            raise ValueError(f"kind {kind!r}; allowed are flat images in {', '.join(_KINDS.values())}")
        if spec.width * spec.height > _MOST_PIXELS:
            raise ValueError(f"{spec.width} x {spec.height} pixels; allowed are {_MOST_PIXELS}")
        colour, alpha = pick_channels(spec.channelnames, layer, by_name=kind == "openexr")
        picked = colour if alpha is None else [*colour, alpha]
        numbers = {spec.channelformat(channel).basetype for channel in picked}
        if not numbers <= {oiio.UINT8, oiio.UINT16, oiio.HALF, oiio.FLOAT, oiio.DOUBLE}:
            raise ValueError(f"numbers of type {spec.format}; allowed are uint8, uint16, half, float and double")
        codes = numbers <= {oiio.UINT8, oiio.UINT16}
        first = min(picked)
        values = source.read_image(0, 0, first, max(picked) + 1, "unknown" if codes else "float")
        if (complaint := source.geterror()) or values is None:
            raise OSError(complaint or "no pixels")
        several = source.seek_subimage(1, 0)
        source.geterror()
    finally:
        source.close()
    shown = values[..., [channel - first for channel in picked]]
    covered = None
    if kind == "openexr":
        shown, covered = _in_display_window(shown, spec)
    orientation = spec.get_int_attribute("Orientation", 1)
    shown = _upright(shown, orientation)
    covered = None if covered is None else _upright(covered, orientation)
    straight = bool(spec.get_int_attribute("oiio:UnassociatedAlpha"))
    return _Stored(
        colour=shown[..., : len(colour)],
        alpha=covered if alpha is None else shown[..., -1],
        premultiplied=kind == "openexr" or (spec.alpha_channel == alpha and not straight),
        colour_tag=_colour_tag(spec),
        exposure=spec.get_float_attribute("hdr:exposure", 1.0) or 1.0,
        notes=tuple(_notes(spec, several, covered is not None)),
    )


def _colour_tag(spec: oiio.ImageSpec) -> str:
    """The colour space that the file states, "" if none; primaries other than Rec.709 come first."""
    primaries = spec.getattribute("chromaticities")
    if primaries is not None and not np.allclose(primaries, PRIMARIES, rtol=0, atol=2e-3):
        return f"chromaticities {', '.join(f'{x:.4g}' for x in primaries)}"
    return spec.get_string_attribute("oiio:ColorSpace")


def _notes(spec: oiio.ImageSpec, several: bool, partly: bool) -> Iterator[str]:
    """What a user should know of how the file was read."""
    if several:
        yield "Of several images in the file, the first was read."
    if partly:
        yield "The data window covers only a part of the image; pixels and alpha are 0 outside it."
    profile = spec.get_string_attribute("ICCProfile:profile_description")
    if profile and "srgb" not in profile.lower():
        yield f"The embedded colour profile {profile!r} was not applied."


def _in_display_window(values: np.ndarray, spec: oiio.ImageSpec) -> tuple[np.ndarray, np.ndarray | None]:
    """The display window of the file: values (0 where there are none), and where they are, if not everywhere."""
    if (spec.x, spec.y, spec.width, spec.height) == (spec.full_x, spec.full_y, spec.full_width, spec.full_height):
        return values, None
    if spec.full_width * spec.full_height > _MOST_PIXELS:
        size = f"{spec.full_width} x {spec.full_height}"
        raise ValueError(f"a display window of {size} pixels; allowed are {_MOST_PIXELS}")
    left, top = spec.x - spec.full_x, spec.y - spec.full_y
    rows = slice(max(top, 0), min(top + spec.height, spec.full_height))
    columns = slice(max(left, 0), min(left + spec.width, spec.full_width))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        raise ValueError("its data window and its display window have no pixel in common")
    shown = np.zeros((spec.full_height, spec.full_width, values.shape[2]), values.dtype)
    covered = np.zeros(shown.shape[:2], np.float32)
    shown[rows, columns] = values[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    covered[rows, columns] = 1
    return shown, None if covered.all() else covered


def _upright(values: np.ndarray, orientation: int) -> np.ndarray:
    """Turns and mirrors as the Exif tag Orientation says (CIPA DC-008, tag 274: 1 is upright)."""
    if orientation >= 5:
        values = values.swapaxes(0, 1)
    rows = slice(None, None, -1 if orientation in (3, 4, 7, 8) else 1)
    columns = slice(None, None, -1 if orientation in (2, 3, 6, 7) else 1)
    return values[rows, columns]


def _unit(values: np.ndarray) -> Float[np.ndarray, "..."]:
    """float32: whole numbers as fractions of their largest, floats as they are."""
    if np.issubdtype(values.dtype, np.integer):
        return (values / np.iinfo(values.dtype).max).astype(np.float32)
    return values.astype(np.float32)


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
