"""POV-Ray's words for vectors and colours; its axes are left-handed, so z changes sign."""

import numpy as np

from .._numbers import listed, text


def place(point) -> str:
    """A point or direction in POV-Ray's axes."""
    x, y, z = point
    return f"<{listed((x, y, -z), ',')}>"


def colour(channels) -> str:
    return f"rgb <{listed(channels, ',')}>"


def grey(channels) -> bool:
    return bool(np.ptp(channels) == 0)


def amount(channels) -> str:
    """One number where the channels agree, else a colour."""
    return text(channels[0]) if grey(channels) else colour(channels)
