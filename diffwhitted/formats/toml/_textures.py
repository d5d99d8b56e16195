"""The table [[texture]] of a kind that is in a file: the file is read beside the scene file, and named from there."""

import os
from pathlib import Path

from ..._errors import InputError, SceneError
from ...records import changed
from ...scene import AbstractTexture, ImageTexture
from ._entries import Entry


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


def named_from(texture: AbstractTexture, folder: Path | None):
    """The reverse: its file as a scene file in that folder names it."""
    file = getattr(texture, "file", None)
    if file is None or folder is None:
        return texture
    return changed(texture, file=Path(os.path.relpath(file, folder)).as_posix())
