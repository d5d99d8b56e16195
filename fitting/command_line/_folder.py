"""The folder that a command writes to: can it be written, and are the pictures of a scene found from there?"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from diffwhitted import Scene


def saved_into(folder: Path):
    """`save_scene`, for a file that is made elsewhere and moved to a folder: the pictures of its shots and
    textures are named from there.
    """
    from diffwhitted import save_scene
    from diffwhitted.records import changed

    def save(scene: Scene, path: Path) -> None:
        def moved(name: str | None) -> str | None:
            return None if name is None else os.path.join(path.parent, os.path.relpath(name, folder))

        def shot_moved(shot):
            noise = moved(shot.noise) if isinstance(shot.noise, str) else shot.noise
            return changed(shot, picture=moved(shot.picture), mask=moved(shot.mask), noise=noise)

        def texture_moved(texture):
            file = getattr(texture, "file", None)
            return texture if file is None else changed(texture, file=moved(file))

        textures = {name: texture_moved(texture) for name, texture in scene.textures.items()}
        save_scene(changed(scene, shots=tuple(map(shot_moved, scene.shots)), textures=textures), path)

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
