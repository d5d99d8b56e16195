"""The numbers of the table [scene] that have a name."""

from collections.abc import Iterator

from ..records import Row
from ._hemisphere import Hemisphere
from ._scene import DISTANCE_FADE, Scene

SETTINGS = (Row("ambient", "colour", "Ambient light I_a, linear RGB; multiplies k_a.", lowest=0), DISTANCE_FADE)


def is_record(scene: Scene, key: str) -> bool:
    """Is the value of this key a record of several numbers?"""
    return isinstance(getattr(scene, key, None), Hemisphere)


def settings_of(scene: Scene) -> Iterator[tuple[str, Row]]:
    """The numbers of [scene], each with the key that it belongs to where that is a record of several."""
    for row in SETTINGS:
        value = getattr(scene, row.name)
        if is_record(scene, row.name):
            yield from ((row.name, inner) for inner in value.ROWS)
        elif value is not None:
            yield "", row


def settings_under(scene: Scene, rest: str) -> tuple[str, str, list[Row]]:
    """Of a name without its family word: the key that is a record of several numbers, or nothing; what follows it; and
    the rows that may be meant there.
    """
    key, _, inner = rest.partition(".")
    owner, rest = (key, inner) if is_record(scene, key) else ("", rest)
    return owner, rest, [row for of, row in settings_of(scene) if of == owner]
