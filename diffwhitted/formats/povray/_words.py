"""POV-Ray's words for vectors, colours and names; its axes are left-handed, so z changes sign."""

import re
from collections.abc import Iterable

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


def identifiers(prefix: str, names: Iterable[str]) -> dict[str, str]:
    """A name that POV-Ray takes for each name, all different."""
    taken: dict[str, str] = {}
    for name in names:
        word = f"{prefix}_{re.sub(r'[^A-Za-z0-9]+', '_', name).strip('_') or 'x'}"[:38]
        found, number = word, 2
        while found in taken.values():
            found, number = f"{word[:34]}_{number}", number + 1
        taken[name] = found
    return taken
