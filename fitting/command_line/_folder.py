"""The folder that a command writes to: can it be written, and are the pictures of a scene found from there?"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from diffwhitted import Scene


def saved_into(folder: Path):
    """`save_scene`, for a TOML file that is made elsewhere and moved to a folder: all files that the scene names are
    named from there.
    """
    from diffwhitted.formats import scene_text, write_file

    def save(scene: Scene, path: Path) -> None:
        write_file(path, scene_text(scene, source=str(path), folder=folder).encode("utf-8"), str(path))

    return save


def check_folder(folder: Path) -> None:
    """Raise `OutputError` now rather than after the fit where a folder cannot be written."""
    from fitting.telling._outputs import OutputError

    there = next(place for place in (folder.absolute(), *folder.absolute().parents) if place.exists())
    if not there.is_dir():
        raise OutputError(
            f"cannot write {folder}: {there} is a file, and a folder is needed; choose another with --out"
        )
    if not os.access(there, os.W_OK | os.X_OK):
        raise OutputError(f"cannot write {folder}: no permission in {there}; choose a folder of your own with --out")
