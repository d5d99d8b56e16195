"""Scene files by their suffix: loading, and saving whole or not at all."""

import os
from collections.abc import Iterable
from pathlib import Path

from .._errors import SceneError
from .._files import not_a_file
from ..records import nearest_name
from ..scene import Precision, Scene
from ._format import SceneFormat, Written
from ._kinds import FORMATS, format_of

LARGEST_FILE = 64 * 2**20
"""Bytes; a larger file is refused before it is read."""


def load_scene(path: str | os.PathLike, *, precision: Precision = "float32") -> Scene:
    """The scene in a file, whose suffix says the format: TOML, unless another is known by that suffix.

    Arguments: `path` of the file; `precision` of every array of the scene.
    Raises `SceneError`, one message that names the file, the place in it, the value, what is allowed
    and what to try: for a file that cannot be read, for broken TOML, for an invalid scene, and for a format that is
    only written.
    """
    chosen = format_of(Path(path))
    if chosen.parse is None:
        read = _suffixes(one for one in FORMATS if one.parse)
        raise SceneError(f"{str(path)}: scenes for {chosen.name} are written, not read; give a scene in {read}")
    return chosen.parse(_read(Path(path)), str(path), precision)


def save_scene(scene: Scene, path: str | os.PathLike, *, form: SceneFormat | None = None) -> tuple[str, ...]:
    """Write a scene to a file, whole or not at all, and say what the file does not hold.

    The suffix says the format, unless `form`, one of `diffwhitted.formats.FORMATS`, does. A scene loaded from TOML has
    the same bits. Other programs' formats (.pov, .xml of Mitsuba 3, .gltf, .mtl), tables (.json, .tex, .md) hold less:
    returns a sentence for all that is lost or said by the nearest that the format has, none where nothing is. The
    file says so too.

    Raises `SceneError` where the file cannot be written, the scene is not valid, or the format is one that is only
    read.
    """
    chosen = format_of(Path(path)) if form is None else form
    if chosen.write is None:
        written = _suffixes(one for one in FORMATS if one.write)
        raise SceneError(f"{str(path)}: scenes in {chosen.name} are read, not written; write it as {written}")
    made = chosen.write(scene, str(path))
    made = made if isinstance(made, Written) else Written(made)
    target = Path(os.path.realpath(path))
    files = {target.with_name(target.stem + ending): data for ending, data in made.beside.items()}
    for place, data in {**files, target: made.data}.items():
        write_file(place, data, str(path) if place == target else str(place))
    return made.lost


def _suffixes(formats: Iterable[SceneFormat]) -> str:
    return ", ".join(suffix for one in formats for suffix in one.suffixes)


def write_file(target: Path, data: bytes, said: str) -> None:
    """Write one file, whole or not at all; `said` is what messages call it. Raises `SceneError`."""
    if kind := not_a_file(target):
        raise SceneError(f"{said}: this is {kind}, which would be lost; give the name of a file")
    partial = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        try:
            partial.write_bytes(data)
            os.replace(partial, target)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        advice = "; make the folder first" if not target.parent.is_dir() else ""
        raise SceneError(f"{said}: cannot be written: {error.strerror}{advice}") from None


def _read(path: Path) -> bytes:
    if kind := not_a_file(path):
        raise SceneError(f"{path}: this is {kind}; write the scene to a file and give its name")
    try:
        with open(path, "rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        beside = [p.name for p in path.parent.glob("*.toml")] if path.parent.is_dir() else []
        raise SceneError(f"{path}: there is no such file.{nearest_name(path.name, beside)}") from None
    except IsADirectoryError:
        raise SceneError(
            f"{path}: this is a folder; name the scene file in it, such as {path / 'scene.toml'}"
        ) from None
    except PermissionError:
        raise SceneError(f"{path}: no permission to read it; allow it with: chmod u+r {path}") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(data) > LARGEST_FILE:
        raise SceneError(f"{path}: more than {LARGEST_FILE >> 20} MiB; allowed is less. Is this a scene file?")
    return data
