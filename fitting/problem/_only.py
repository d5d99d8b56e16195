"""Masks by what pixels see: those that show some objects and nothing else."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from diffwhitted import layers
from diffwhitted.scene import AbstractCamera, Scene, nearest_name

from .._errors import FitError
from ._target import Target, camera_name, is_file


def only(scene: Scene, camera: AbstractCamera | str, names: str | Collection[str]) -> np.ndarray:
    """A mask (height, width): 1 where a pixel sees one of these objects, and so do its eight neighbours; 0 elsewhere.

    - `camera`: as it stands, or by its name in the scene; `names`: of objects.

    What counts is what the ray through the middle of a pixel meets first: a mirror image of an object is not it, and
    glass is what is seen, not what is behind it. The edge of the picture is no edge of an object. Raises `FitError` for
    a name that no object has, and where no pixel is left.
    """
    names = (names,) if isinstance(names, str) else tuple(names)
    there = [thing.name for thing in scene.objects]
    for name in names:
        if name not in there:
            raise FitError(
                f"only: there is no object {name!r}; there is {', '.join(there) or 'none at all'}."
                f"{nearest_name(name, there)}"
            )
    called = camera if isinstance(camera, str) else "that was given"
    if isinstance(camera, str):
        if camera not in scene.cameras:
            raise FitError(
                f"only: no camera {camera!r}; there is {', '.join(scene.cameras)}.{nearest_name(camera, scene.cameras)}"
            )
        camera = scene.cameras[camera]
    seen = layers(scene, camera)
    mine = np.isin(seen.object, [seen.names.index(name) for name in names])
    if not mine.any():
        raise FitError(
            f"only: the camera {called} sees no {' and no '.join(names)}; name another object, or look at it"
        )
    wide = np.pad(mine, 1, mode="edge")
    height, width = mine.shape
    inside = np.all([wide[r : r + height, c : c + width] for r in range(3) for c in range(3)], axis=0)
    if not inside.any():
        raise FitError(
            f"only: each pixel of the camera {called} that sees {' or '.join(names)} is at an edge; take a larger one"
        )
    return inside.astype(np.float64)


def only_these(scene: Scene, targets: Sequence[Target], names: str | Collection[str]) -> list[Target]:
    """The targets with what `only` leaves out masked as well."""
    found = []
    for target in targets:
        camera = camera_name(scene, target.camera or (target.shot and target.shot.camera))
        given = target.mask if target.mask is not None or not is_file(target.image) else target.image.alpha
        mask = only(scene, camera, names)
        if given is not None and np.shape(given) == mask.shape:
            mask = mask * np.asarray(given)
        elif given is not None:
            mask = np.asarray(given)  # of another size, which is refused with the others
        found.append(replace(target, mask=mask))
    return found
