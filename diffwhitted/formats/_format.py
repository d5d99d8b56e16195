"""The contract of a format of scene files."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ..scene import Precision, Scene


@dataclass(frozen=True)
class Written:
    """A scene as a format has it."""

    data: bytes
    """Of the file."""
    lost: tuple[str, ...] = ()
    """What the format cannot say, or says by the nearest that it has: a sentence each."""
    beside: Mapping[str, bytes] = field(default_factory=dict)
    """Further files that the first one names, by what comes after its own name without the suffix."""


@dataclass(frozen=True)
class SceneFormat:
    """One format, which is read, written, or both."""

    name: str
    """What messages call it."""
    suffixes: tuple[str, ...]
    """Of its files, in small letters, with the dot."""
    parse: Callable[[bytes, str, Precision], Scene] | None = None
    """The scene in the bytes of a file, what messages call that file, and the precision of its arrays; None for a
    format that is only written. Raises `SceneError`.
    """
    write: Callable[[Scene, str], bytes | Written] | None = None
    """The bytes of a file that holds the scene, and what messages call it, with what is lost if anything is; None for a
    format that is only read.
    """
