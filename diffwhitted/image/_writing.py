"""Image files out, all through OpenImageIO: each written whole or not at all.

In memory: linear Rec.709, straight (not premultiplied) alpha, row 0 on top. In the file: whatever the
format holds. Every failure is an `ImageError` of one sentence, and nothing is printed.
"""

import json
import os
import secrets
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from jaxtyping import Float

from .._files import not_a_file
from ._colour import PRIMARIES
from ._display import check_exposure, display_codes
from ._faults import ImageError, one_line, refuse, utf8
from ._further import with_layers

_FLOAT32 = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class ImageFormat:
    """What a format holds: display codes of so many `bits`, or (0) linear floats in an interval."""

    # libpng and libjpeg speak to the terminal about a longer side, or end the program.
    side: int = 2**24
    bits: int = 0
    interval: tuple[float, float] = (-_FLOAT32, _FLOAT32)
    finite: bool = True
    alpha: bool = True
    settings: dict[str, Any] = field(default_factory=dict)


_EXR = ImageFormat(finite=False, settings={"compression": "zip"})
_TIFF = ImageFormat(finite=False, settings={"compression": "zip", "tiff:write_exif": 0})
_JPEG = ImageFormat(side=65_500, bits=8, alpha=False, settings={"CompressionQuality": 95, "jpeg:subsampling": "4:4:4"})
_WRITTEN = {
    ".exr": _EXR,
    ".hdr": ImageFormat(interval=(0.0, 1.7e38), alpha=False),
    ".tif": _TIFF,
    ".tiff": _TIFF,
    ".png": ImageFormat(side=1_000_000, bits=16, settings={"png:compressionLevel": 3}),
    ".jpg": _JPEG,
    ".jpeg": _JPEG,
}


def write_image(
    path: str | os.PathLike,
    pixels: Float[np.ndarray, "height width 3"],
    *,
    metadata: dict[str, Any] | None = None,
    exposure: float = 0.0,
    half: bool = False,
    alpha: Float[np.ndarray, "height width"] | None = None,
    layers: Mapping[str, np.ndarray] | None = None,
) -> None:
    """Writes linear Rec.709 pixels in the format that the extension names, whole or not at all.

    .exr .hdr .tif .tiff hold linear 32 bit floats (a .hdr shares one exponent among three 8 bit
    mantissas); .png holds 16 bit and .jpg .jpeg 8 bit codes of the display transform.

    pixels: (height, width, 3) floats; NaN and infinity only in .exr and .tif.
    metadata: a JSON object in ImageDescription; its "Software" becomes the Software. A .hdr keeps none. A
    .tif has "oiio:ColorSpace" there too.
    exposure: stops, for .png and .jpg. half: 16 bit floats, for .exr.
    alpha: (height, width) in [0, 1], for .exr, .tif and .png. An .exr stores pixels premultiplied,
    so colour under alpha 0 is lost there; the others store it straight.
    layers: for .exr, further channels (height, width) by name, such as "depth.Z", 32 bit floats whatever `half` says.

    Raises ImageError when the pixels do not fit the format or the file cannot be written; a file
    that was there before is then as it was.
    """
    form = check_writable(path, exposure=exposure, half=half)
    path = Path(path)
    stored = _checked(path, pixels, replace(form, interval=(-65504.0, 65504.0)) if half else form)
    if form.bits:
        stored = display_codes(stored, form.bits, exposure=exposure)
    if alpha is not None:
        stored = _with_alpha(path, stored, alpha, form)
    spec = _described(path, stored, form, half, metadata or {})
    if layers:
        spec, stored = with_layers(path, spec, stored, layers)
    _write_whole(path, spec, stored)


def check_writable(path: str | os.PathLike, *, exposure: float = 0.0, half: bool = False) -> ImageFormat:
    """Can an image be written there, as far as one can tell without its pixels? The format that it gets.

    For programs that would rather know before the work than after it. Raises ImageError as `write_image`.
    """
    path = Path(path)
    extension = path.suffix.lower()
    if extension not in _WRITTEN:
        raise ImageError(f"{path}: cannot write the extension {extension!r}; use one of {' '.join(_WRITTEN)}.")
    form = _WRITTEN[extension]
    if half and form is not _EXR:
        raise ImageError(f"{path}: half = True is for .exr; leave it out, or write .exr.")
    if exposure and not form.bits:
        raise ImageError(f"{path}: exposure = {exposure} is for display, {extension} is linear; use 0, or .png.")
    try:
        check_exposure(exposure)
        check_place(path)
    except ImageError:
        raise
    except (OSError, ValueError) as error:
        raise ImageError(f"{path}: {one_line(error)}.") from None
    return form


def check_place(path: Path) -> None:
    """Raise `ImageError` unless a file may be written there."""
    target = Path(os.path.realpath(path))
    if not target.parent.is_dir():
        raise ImageError(f"{path}: the folder {target.parent} does not exist; make it first.")
    if target.is_dir():
        raise ImageError(f"{path}: a folder; give the name of a file.")
    if kind := not_a_file(target):
        raise ImageError(f"{path}: this is {kind}, which would be lost; give the name of a file.")
    if not os.access(target.parent, os.W_OK) or (target.exists() and not os.access(target, os.W_OK)):
        raise ImageError(f"{path}: no permission to write there; choose another name or folder.")


def _checked(path: Path, pixels: np.ndarray, form: ImageFormat) -> Float[np.ndarray, "height width 3"]:
    """The pixels as float32, if the format can hold them."""
    pixels = np.asarray(pixels)
    if pixels.ndim != 3 or pixels.shape[2] != 3 or 0 in pixels.shape:
        raise ImageError(f"{path}: pixels of shape {pixels.shape}; allowed is (height, width, 3), none of them 0.")
    if not np.issubdtype(pixels.dtype, np.floating):
        raise ImageError(f"{path}: pixels of type {pixels.dtype}; allowed are floats. Try decode_from_display.")
    if max(pixels.shape) > form.side:
        size = f"{pixels.shape[1]} x {pixels.shape[0]}"
        raise ImageError(f"{path}: {size} pixels; at most {form.side} a side are allowed. Try .exr.")
    pixels = pixels.astype(np.float64)
    finite = np.isfinite(pixels)
    if form.finite:
        refuse(
            path, np.asarray(~finite.all(axis=2)), "are not finite, as they must be here; find the cause, or use .exr"
        )
    low, high = form.interval
    outside = np.asarray((finite & ((pixels < low) | (pixels > high))).any(axis=2))
    refuse(path, outside, f"are outside [{low:g}, {high:g}], all it holds; scale them, or use a float .exr")
    return np.ascontiguousarray(pixels, np.float32)


def _with_alpha(path: Path, stored: np.ndarray, alpha: np.ndarray, form: ImageFormat) -> np.ndarray:
    """Stored pixels with alpha as the fourth channel, premultiplied where the format is."""
    alpha = np.asarray(alpha)
    if not form.alpha:
        raise ImageError(f"{path}: {path.suffix} holds no alpha; leave it out, or write .exr, .tif or .png.")
    if alpha.shape != stored.shape[:2]:
        raise ImageError(f"{path}: alpha of shape {alpha.shape}; allowed is {stored.shape[:2]}, that of the pixels.")
    refuse(path, ~((alpha >= 0) & (alpha <= 1)), "have alpha outside [0, 1] or not a number; 1 is opaque")
    if form is _EXR:
        with np.errstate(invalid="ignore"):
            stored = np.where(alpha[..., None] > 0, stored * alpha[..., None], 0)
    if form.bits:
        alpha = np.rint(alpha * np.iinfo(stored.dtype).max)
    return np.concatenate([stored, alpha[..., None]], axis=2).astype(stored.dtype if form.bits else np.float32)


def _described(
    path: Path, stored: np.ndarray, form: ImageFormat, half: bool, metadata: dict[str, Any]
) -> oiio.ImageSpec:
    """What the file will say of itself."""
    number = {"float32": "half" if half else "float"}.get(stored.dtype.name, stored.dtype.name)
    spec = oiio.ImageSpec(stored.shape[1], stored.shape[0], stored.shape[2], number)
    about = dict(metadata)
    software = str(about.pop("Software", "diffwhitted"))
    space = "srgb_rec709_scene" if form.bits else "lin_rec709_scene"
    if form is _TIFF:
        # OpenImageIO has no tag for the colour space of a TIFF of floats.
        about["oiio:ColorSpace"] = space
    description = json.dumps(about, default=str) if about else ""
    # libjpeg ends the whole program on a longer one.
    if form is _JPEG and len((software + description).encode()) > 60_000:
        raise ImageError(f"{path}: metadata too long for a JPEG, which holds 60000 bytes; leave some out, or use .png.")
    spec.attribute("Software", software)
    if description:
        spec.attribute("ImageDescription", description)
    spec.attribute("oiio:ColorSpace", space)
    spec.attribute("oiio:UnassociatedAlpha", int(form is not _EXR))
    if form is _EXR:
        spec.attribute("chromaticities", oiio.TypeDesc("float[8]"), PRIMARIES)
    for name, value in form.settings.items():
        spec.attribute(name, value)
    return spec


def _write_whole(path: Path, spec: oiio.ImageSpec, stored: np.ndarray) -> None:
    """Writes beside the target under another name and renames: the target is whole or untouched."""
    temporary = None
    try:
        target = Path(os.path.realpath(path))
        # libjpeg ends the whole program when the disk is full, so there must be room before it starts.
        if shutil.disk_usage(target.parent).free < 2 * stored.nbytes + 2**16:
            raise ImageError(f"{path}: the disk is nearly full; make room for {2 * stored.nbytes + 2**16} bytes.")
        temporary = target.with_name(f".{secrets.token_hex(8)}{path.suffix.lower()}")
        output = oiio.ImageOutput.create(utf8(temporary))
        if output is None:
            raise OSError(oiio.geterror())
        done = output.open(utf8(temporary), spec) and output.write_image(stored)
        done = output.close() and done
        if (complaint := output.geterror()) or not done:
            raise OSError(complaint or "no reason given")
        os.replace(temporary, target)
    except ImageError:
        raise
    except (OSError, ValueError, RuntimeError) as error:
        raise ImageError(f"{path}: cannot be written ({one_line(error)}); check the disk and the folder.") from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
