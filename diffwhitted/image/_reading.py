"""Image files in: linear Rec.709, straight (not premultiplied) alpha, row 0 on top, whatever the file holds.

Every failure is an `ImageError` of one sentence, and nothing is printed.
"""

import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from ._codes import Codes, three, unit
from ._encodings import checked_encoding
from ._faults import ImageError, refuse
from ._jpeg import Jpeg
from ._statements import Decoding
from ._stored import Stored, load, located


@dataclass(frozen=True, eq=False)
class ImageFile:
    """What an image file holds.

    pixels: (height, width, 3) float32, linear Rec.709, straight alpha; NaN and infinity as stored.
    alpha: (height, width) float32, or None where the file has none. path: where it was read.
    colour_space: of the numbers in the file, in words, such as "linear Rec.709" or "sRGB".
    notes: what a user should know of how the file was read, a sentence each; mostly empty.
    clipped: (height, width), where a channel of 8 or 16 bit colour has its largest code; None for floats.
    encoding: how the numbers stand for light, as `read_image` takes it; None for the own curves of an ICC profile.
    monochrome: has the file one channel of colour, or three that are equal everywhere?
    lossy: have the codes been changed after rounding (JPEG, WebP, a palette), or may they have been?
    jpeg: how a JPEG was compressed, where that can be done again; None for all else.
    """

    pixels: Float[np.ndarray, "height width 3"]
    alpha: Float[np.ndarray, "height width"] | None
    path: Path
    colour_space: str
    notes: tuple[str, ...] = ()
    clipped: Bool[np.ndarray, "height width"] | None = None
    encoding: str | None = "linear"
    monochrome: bool = False
    lossy: bool = False
    jpeg: Jpeg | None = None
    _codes: Codes | None = field(default=None, repr=False)

    @cached_property
    def cells(self) -> tuple[Float[np.ndarray, "height width 3"], Float[np.ndarray, "height width 3"]] | None:
        """The lowest and the highest linear light that is stored as what the file holds, float64.

        For integers the light of half a code below and above; -inf below code 0, inf above the largest. For 16 bit
        floats the light halfway to the next ones. None for 32 bit floats, Radiance and lossy files, where primaries
        were converted, and where colour was divided by an alpha other than 1.
        """
        with np.errstate(all="ignore"):
            return None if self._codes is None else self._codes.cells()

    @cached_property
    def step(self) -> Float[np.ndarray, "height width 3"] | None:
        """The width of a code in linear light at each value, float64; of lossy files too. None for 32 bit floats.

        At the ends of the range twice the half that is within. Through a matrix M of primaries, the root of the sum
        of squares (M_ij step_j)^2, as for independent errors.
        """
        with np.errstate(all="ignore"):
            return None if self._codes is None else self._codes.step()


def read_image(path: str | os.PathLike, *, layer: str | None = None, encoding: str | None = None) -> ImageFile:
    """Reads a picture as linear Rec.709: OpenEXR, TIFF, PNG, JPEG, Radiance, and what else OpenImageIO reads.

    encoding: how the numbers stand for light: "linear", "srgb", "rec709", "cineon" or "gamma:2.2" (any number > 0);
    None for what the file says (CICP, ICC profile, sRGB, gAMA and cHRM of a PNG, name of a colour space), and where
    it says nothing, sRGB for whole numbers and linear for floats. Primaries other than Rec.709's (of an ICC profile,
    cHRM, the chromaticities of an OpenEXR file) are converted with Bradford's adaptation, white to white.

    layer: the layer or part that is the picture, by its name, or one channel, which is then grey; `FILE:NAME` in
    place of the path says the same where no file has that whole name. Without it the picture is R, G, B (or Y, or R
    alone, as grey) outside of layers, or in the only layer or part that has them; depth never is.

    Grey becomes three equal channels. Premultiplied colour (OpenEXR by convention, others where they say so) is
    divided by alpha where alpha > 0 and kept where it is 0. Pixels are turned the way the file's orientation says.
    Where the data window of an OpenEXR file does not reach, pixels and alpha are 0; what lies outside its display
    window is cut off.

    Raises ImageError for a file that is missing, broken, cut short, no picture, of several pictures without a word
    on which, or of a colour space that is not known; InputError for another encoding.
    """
    encoding = None if encoding is None else checked_encoding(encoding)
    path, layer = located(path, layer)
    stored = load(path, layer, encoding)
    floating = stored.bits == 0
    clipped = None if floating else (stored.colour == np.iinfo(stored.colour.dtype).max).any(axis=2)
    decoding = stored.decoding
    # A file may hold NaN and infinity; they pass through, without warnings.
    with np.errstate(all="ignore"):
        alpha = None if stored.alpha is None else unit(stored.alpha)
        codes = _codes(stored, alpha)
        pixels = codes.light()
        first = pixels[..., :1]
        monochrome = pixels.shape[2] == 1 or np.array_equal(pixels, np.broadcast_to(first, pixels.shape), True)
        # Grey is grey in any primaries.
        if monochrome:
            codes = replace(codes, decoding=replace(decoding, matrix=None))
        elif decoding.matrix is not None:
            pixels = (pixels @ decoding.matrix.T).astype(np.float32)
        pixels = three(pixels / np.float32(stored.exposure))
    kept = codes if codes.bits or codes.half or codes.mantissa else None
    space = _space(decoding)
    return ImageFile(
        pixels,
        alpha,
        path,
        space,
        stored.notes,
        clipped,
        decoding.encoding,
        monochrome,
        stored.lossy,
        stored.jpeg if decoding.encoding is not None else None,
        kept,
    )


def _codes(stored: Stored, alpha: np.ndarray | None) -> Codes:
    """The numbers of colour, with what they were multiplied by where that is not 1 everywhere."""
    opacity = None
    if stored.premultiplied and alpha is not None:
        opacity = np.where(alpha > 0, alpha, np.float32(1))
        opacity = None if (opacity == 1).all() else opacity
    return Codes(
        stored.colour,
        stored.decoding,
        opacity,
        stored.exposure,
        stored.bits,
        stored.half,
        not stored.lossy,
        8 if stored.shared_exponent else 0,
    )


def _space(decoding: Decoding) -> str:
    """In words: "linear Rec.709", "sRGB", and the like."""
    if decoding.encoding is None:
        return "an ICC profile"
    if decoding.matrix is not None:
        return f"{decoding.encoding}, other primaries"
    return {"linear": "linear Rec.709", "srgb": "sRGB"}.get(decoding.encoding, decoding.encoding)


def read_mask(path: str | os.PathLike) -> Float[np.ndarray, "height width"]:
    """Reads a mask: (height, width) float32 in [0, 1], the numbers of the file with no colour transform.

    8 and 16 bit codes are divided by 255 and 65535. The file is grey, or colour with equal channels. With
    alpha, the mask is grey over black, so transparent counts as 0. `FILE:NAME` is a layer, as in `read_image`.

    Raises ImageError as `read_image` does, and for unequal channels, NaN, and values outside [0, 1].
    """
    path, layer = located(path, None)
    stored = load(path, layer, "linear")
    colour = unit(stored.colour)
    mask = colour[..., 0]
    if not np.allclose(colour, mask[..., None], rtol=0, atol=1e-3, equal_nan=True):
        raise ImageError(f"{path}: a mask is grey, and the channels of this file differ; save it as greyscale.")
    if stored.alpha is not None and not stored.premultiplied:
        mask = mask * unit(stored.alpha)
    bad = ~((mask >= -1e-4) & (mask <= 1.0001))
    refuse(path, bad, "are outside [0, 1] or not a number; a mask is 1 where a pixel counts")
    return np.clip(mask, 0, 1)


def without_bad_pixels(
    pixels: Float[np.ndarray, "height width 3"], mask: Float[np.ndarray, "height width"] | None = None
) -> tuple[Float[np.ndarray, "height width"], int]:
    """A mask without the pixels that are NaN or infinite, and how many it lost by that.

    mask: of weights, as `read_mask` gives it; None for 1 everywhere. Returns it with 0 where a channel of a pixel is
    not finite, and the number of those pixels whose weight was not 0. float32.

    Raises ImageError for a mask of another size.
    """
    pixels = np.asarray(pixels)
    weights = np.ones(pixels.shape[:2], np.float32) if mask is None else np.asarray(mask, np.float32)
    if weights.shape != pixels.shape[:2]:
        raise ImageError(f"a mask of shape {weights.shape}; allowed is {pixels.shape[:2]}, that of the pixels.")
    bad = ~np.isfinite(pixels).all(axis=2) & (weights != 0)
    return np.where(bad, np.float32(0), weights), int(bad.sum())
