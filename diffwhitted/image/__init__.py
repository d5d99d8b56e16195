"""Pixels: image files, the display transform, and how far two images look apart.

Images are `(height, width, 3)` arrays of linear Rec.709, scene-referred, row 0 on top. `read_image` and
`write_image` take and give that, whatever the file holds and however its numbers stand for light; a
file is written whole or not at all, and whatever is wrong with one is an `ImageError` of a single
sentence. Only `encode_for_display` clips, `count_clipped` says how much, and `ciede2000` compares two
images as a screen would show them.
"""

from typing import TYPE_CHECKING

from .._lazily import lazily
from ._display import ClippedPixels, ciede2000, count_clipped, decode_from_display, display_codes, encode_for_display
from ._encodings import checked_encoding, decode_signal, encode_signal
from ._faults import ImageError
from ._film import dealt, gathered

if TYPE_CHECKING:
    from ._reading import ImageFile, read_image, read_mask, without_bad_pixels
    from ._writing import ImageFormat, check_place, check_writable, write_image

__all__ = [
    "ClippedPixels",
    "ImageError",
    "ImageFile",
    "ImageFormat",
    "check_place",
    "check_writable",
    "checked_encoding",
    "ciede2000",
    "count_clipped",
    "dealt",
    "decode_from_display",
    "decode_signal",
    "display_codes",
    "encode_for_display",
    "encode_signal",
    "gathered",
    "read_image",
    "read_mask",
    "without_bad_pixels",
    "write_image",
]

__getattr__ = lazily(
    __name__,
    dict.fromkeys(("ImageFile", "read_image", "read_mask", "without_bad_pixels"), "_reading")
    | dict.fromkeys(("ImageFormat", "check_place", "check_writable", "write_image"), "_writing"),
)
"""OpenImageIO waits until a picture is read or written."""
