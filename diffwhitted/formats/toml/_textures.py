"""The table [[texture]] of a kind that is in a file, and how a scene file names the files of textures and objects."""

import os
from pathlib import Path
from typing import TypeVar

from ..._errors import InputError, SceneError
from ...records import changed
from ...scene import AbstractObject, AbstractTexture, ImageTexture
from ._entries import Entry

R = TypeVar("R", AbstractTexture, AbstractObject)


class ImageTable(Entry):
    """A picture: its texels are in the file that is named."""

    def record(self, place: str, dtype):
        """The texture with the texels of its file. Raises `SceneError` naming the texture and the file."""
        from ...image import ImageError, read_image  # OpenImageIO takes long to load

        stated = {key: self.value(key, place, dtype) for key in type(self).model_fields if key not in ("type", "name")}
        file, encoding = stated["file"], stated["encoding"]
        try:
            texels = read_image(file, encoding=encoding).pixels
        except ImageError as error:
            raise SceneError(f"{place}: file: {error}") from None
        except InputError as error:
            raise SceneError(f"{place}: {error}") from None
        return self.made(texels=texels, place=place, **stated)

    @classmethod
    def plain(cls, record, **stated) -> dict:
        if record.file is None:
            raise SceneError(
                f"texture {stated.get('name', '')!r}: its texels are in no file, and a scene file only names one; "
                "write them with write_image(FILE, texels), and build the texture with file = FILE besides"
            )
        return super().plain(record, **stated)


TABLES: dict[type, type[Entry]] = {ImageTexture: ImageTable}
"""The table of a texture that is not its rows alone."""


def located(entry: Entry, folder: Path | None) -> Entry:
    """The table with its file relative to the working folder, in place of the one that holds the scene file."""
    file = getattr(entry, "file", None)
    if file is None or folder is None:
        return entry
    return entry.model_copy(update={"file": os.path.normpath(folder / file)})


def named_from(record: R, folder: Path | None) -> R:
    """The reverse: a texture or an object whose file is called as a scene file in that folder names it."""
    file = getattr(record, "file", None)
    if file is None or folder is None:
        return record
    return changed(record, file=Path(os.path.relpath(file, folder)).as_posix())
