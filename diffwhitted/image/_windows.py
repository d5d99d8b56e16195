"""Where the pixels of a file lie in its picture: the windows of OpenEXR, and the orientation of photographs."""

import numpy as np
import OpenImageIO as oiio

from ._faults import Unusable

MOST_PIXELS = 2**27
"""A broken header may claim any size."""


def in_display_window(values: np.ndarray, spec: oiio.ImageSpec) -> tuple[np.ndarray, np.ndarray | None]:
    """The display window of the file: values (0 where there are none), and where they are, if not everywhere."""
    if (spec.x, spec.y, spec.width, spec.height) == (spec.full_x, spec.full_y, spec.full_width, spec.full_height):
        return values, None
    if spec.full_width * spec.full_height > MOST_PIXELS:
        size = f"{spec.full_width} x {spec.full_height}"
        raise Unusable(f"its display window has {size} pixels; allowed are {MOST_PIXELS}")
    left, top = spec.x - spec.full_x, spec.y - spec.full_y
    rows = slice(max(top, 0), min(top + spec.height, spec.full_height))
    columns = slice(max(left, 0), min(left + spec.width, spec.full_width))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        raise Unusable("its data window and its display window have no pixel in common; write it with both alike")
    shown = np.zeros((spec.full_height, spec.full_width, values.shape[2]), values.dtype)
    covered = np.zeros(shown.shape[:2], np.float32)
    shown[rows, columns] = values[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    covered[rows, columns] = 1
    return shown, None if covered.all() else covered


def upright(values: np.ndarray, orientation: int) -> np.ndarray:
    """Turns and mirrors as the Exif tag Orientation says (CIPA DC-008, tag 274: 1 is upright)."""
    if orientation >= 5:
        values = values.swapaxes(0, 1)
    rows = slice(None, None, -1 if orientation in (3, 4, 7, 8) else 1)
    columns = slice(None, None, -1 if orientation in (2, 3, 6, 7) else 1)
    return values[rows, columns]
