"""The one list of formats of scene files. A new format is a file or a folder here, and one line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import PurePath

from ._format import SceneFormat
from ._json import JSON
from ._mtl import MTL
from ._nff import NFF
from ._obj import BARE, OBJ
from ._tables import LATEX, MARKDOWN
from .challenge import CHALLENGE
from .gltf import GLB, GLTF
from .mitsuba import MITSUBA
from .povray import POVRAY
from .toml import TOML

FORMATS: list[SceneFormat] = [
    TOML, NFF, POVRAY, MITSUBA, CHALLENGE, GLTF, GLB, OBJ, BARE, MTL, JSON, LATEX, MARKDOWN,
]  # fmt: skip


@contextmanager
def including_format(one: SceneFormat) -> Iterator[SceneFormat]:
    """The list with one format more, for the length of a `with` block."""
    FORMATS.append(one)
    try:
        yield one
    finally:
        FORMATS.remove(one)


def format_of(path: PurePath) -> SceneFormat:
    """The format of a file by its suffix; TOML where the suffix says nothing."""
    return next((one for one in FORMATS if path.suffix.lower() in one.suffixes), TOML)
