"""PNG files of few colours: 1, 2, 4 or 8 bits a pixel, which number the colours of a palette."""

import json
import os
import secrets
from pathlib import Path
from typing import Any

import numpy as np

from ._display import display_codes
from ._faults import ImageError, one_line

LARGEST_PALETTE = 256


def write_palette(path: str | os.PathLike, shown: Any, levels: int, *, metadata: dict[str, Any] | None = None) -> None:
    """Write a picture of few levels as a PNG with a palette, whole or not at all.

    shown: (height, width) or (height, width, 3) in [0, 1] on `levels` that are evenly spaced in linear light, as the
    functions of `diffwhitted.display` return it. The palette holds the colours that are there, by their 8 bit codes of
    the display transform, and a pixel has as few bits as number them: black and white is 1 bit.

    metadata: a JSON object in ImageDescription. Raises `ImageError` for another suffix, for a picture of more than 256
    colours, for values that are on no level, and where the file cannot be written.
    """
    from PIL import Image, PngImagePlugin

    from ._writing import check_writable  # OpenImageIO takes long to load

    path, shown = Path(path), np.asarray(shown)
    if path.suffix.lower() != ".png":
        raise ImageError(f"{path}: a palette is for .png; use that extension.")
    check_writable(path)
    numbers = np.rint(shown * (levels - 1))
    if shown.ndim not in (2, 3) or abs(numbers - shown * (levels - 1)).max() > 1e-3 or numbers.min() < 0:
        raise ImageError(f"{path}: some values are on none of {levels} levels in [0, 1]; give what a dither returns.")
    # Number the colours.
    numbers = numbers if shown.ndim == 3 else np.repeat(numbers[..., None], 3, axis=2)
    height, width = numbers.shape[:2]
    colours, which = np.unique(numbers.reshape(-1, 3), axis=0, return_inverse=True)
    if len(colours) > LARGEST_PALETTE:
        raise ImageError(f"{path}: {len(colours)} colours; at most {LARGEST_PALETTE} are allowed. Use fewer levels.")
    bits = next(bits for bits in (1, 2, 4, 8) if len(colours) <= 2**bits)
    picture = Image.fromarray(which.reshape(height, width).astype(np.uint8), "P")
    picture.putpalette(display_codes(colours / (levels - 1), 8).tobytes())
    # Say what the codes stand for, and what the picture is.
    about = PngImagePlugin.PngInfo()
    about.add(b"sRGB", b"\0")
    about.add_text("Software", str((metadata or {}).get("Software", "diffwhitted")))
    if metadata:
        about.add_itxt("ImageDescription", json.dumps(metadata, default=str))
    temporary = path.with_name(f".{secrets.token_hex(8)}.png")
    try:
        picture.save(temporary, "PNG", bits=bits, pnginfo=about)
        os.replace(temporary, Path(os.path.realpath(path)))
    except (OSError, ValueError) as error:
        raise ImageError(f"{path}: cannot be written ({one_line(error)}); check the disk and the folder.") from None
    finally:
        temporary.unlink(missing_ok=True)
