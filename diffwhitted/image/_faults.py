"""What every image file has in common when it cannot be used: one error, in one sentence."""

import os
from pathlib import Path

import numpy as np

from .._errors import InputError


class ImageError(InputError):
    """An image file, or the pixels for one, cannot be used: which one, why, and what to try."""


class Unusable(ValueError):
    """Why a file that can be opened is not taken, and what to do; without its name."""


def refuse(path: Path, bad: np.ndarray, problem: str) -> None:
    """Raises ImageError when any pixel of the map is bad, saying how many and where the first is."""
    if bad.any():
        row, column = np.argwhere(bad)[0]
        which = f"{bad.sum()} of {bad.size} pixels, the first in row {row} and column {column}"
        raise ImageError(f"{path}: {which}, {problem}.")


def utf8(path: Path) -> str:
    """The path as OpenImageIO takes it; UnicodeEncodeError for a name that is not UTF-8."""
    return os.fspath(path).encode().decode()


def one_line(error: BaseException) -> str:
    """The reason that an error gives, without line breaks."""
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(reason.split()).rstrip(".")
