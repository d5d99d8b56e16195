"""Tables of what is in a picture file, and how a scene file names the files of textures, backgrounds and objects."""

import os
from pathlib import Path
from typing import ClassVar, TypeVar

from ..._errors import InputError, SceneError
from ...records import changed
from ...scene import AbstractBackground, AbstractObject, AbstractTexture, EnvironmentBackground, ImageTexture
from ._entries import Entry

R = TypeVar("R", AbstractTexture, AbstractObject, AbstractBackground)
FILE_KEYS = "file", "environment"
"""The keys that name a file."""


class ImageTable(Entry):
    """A picture: its texels are in the file that is named."""

    key: ClassVar[str] = "file"
    """What names it."""

    def record(self, place: str, dtype):
        """The record with the texels of its file. Raises `SceneError` naming the record and the file."""
        from ...image import ImageError, read_image  # OpenImageIO takes long to load

        stated = {key: self.value(key, place, dtype) for key in type(self).model_fields if key not in ("type", "name")}
        file, encoding = stated[self.key], stated["encoding"]
        try:
            texels = read_image(file, encoding=encoding).pixels
        except ImageError as error:
            raise SceneError(f"{place}: {self.key}: {error}") from None
        except InputError as error:
            raise SceneError(f"{place}: {error}") from None
        return self.made(texels=texels, place=place, **stated)

    @classmethod
    def plain(cls, record, **stated) -> dict:
        if getattr(record, cls.key) is None:
            what = f"texture {stated['name']!r}" if "name" in stated else "scene: background"
            raise SceneError(
                f"{what}: its texels are in no file, and a scene file only names one; "
                f"write them with write_image(FILE, texels), and build it with {cls.key} = FILE besides"
            )
        return super().plain(record, **stated)


class EnvironmentTable(ImageTable):
    """A map of all that is far away, in a picture file."""

    key: ClassVar[str] = "environment"


BACKGROUND_TABLES: dict[type, type[Entry]] = {EnvironmentBackground: EnvironmentTable}
"""The table of a background that is not its rows alone."""
TABLES: dict[type, type[Entry]] = {ImageTexture: ImageTable}
"""The table of a texture that is not its rows alone."""


def located(entry: Entry, folder: Path | None) -> Entry:
    """The table with its file relative to the working folder, in place of the one that holds the scene file."""
    stated = {key: file for key in FILE_KEYS if (file := getattr(entry, key, None)) is not None}
    if folder is None:
        return entry
    return entry.model_copy(update={key: os.path.normpath(folder / file) for key, file in stated.items()})


def named_from(record: R, folder: Path | None) -> R:
    """The reverse: a record whose file is called as a scene file in that folder names it."""
    stated = {key: file for key in FILE_KEYS if (file := getattr(record, key, None)) is not None}
    if folder is None:
        return record
    return changed(record, **{key: Path(os.path.relpath(file, folder)).as_posix() for key, file in stated.items()})
