"""The contract of a format of scene files."""

from collections.abc import Callable
from dataclasses import dataclass

from ..scene import Precision, Scene


@dataclass(frozen=True)
class SceneFormat:
    """One format."""

    name: str
    """What messages call it."""
    suffixes: tuple[str, ...]
    """Of its files, in small letters, with the dot."""
    parse: Callable[[bytes, str, Precision], Scene]
    """The scene in the bytes of a file, what messages call that file, and the precision of its arrays. Raises
    `SceneError`.
    """
    write: Callable[[Scene, str], bytes] | None = None
    """The bytes of a file that holds the scene, and what messages call it; None for a format that is only read."""
