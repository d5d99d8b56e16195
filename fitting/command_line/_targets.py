"""The pictures of a fit from their files: target, mask or alpha, and noise, by camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from diffwhitted import InputError
from diffwhitted.image import read_image, read_mask
from fitting import Target

from ._named_values import files_of_cameras
from ._options import chosen_camera

if TYPE_CHECKING:
    from diffwhitted import Scene


def read_targets(scene: Scene, given: Sequence[str], masks: Sequence[str], camera: str | None, noise: float | None,
                 note: Callable[[str], None]) -> list[Target]:
    """One target for each `[CAMERA=]IMAGE`, its mask from `[CAMERA=]FILE` or from its alpha channel.

    `note` is told what a user should know. Raises `InputError` for what cannot be read or paired.
    """
    if noise is not None and not 0 < noise < float("inf"):
        raise InputError(f"--noise {noise:g}: allowed is a number > 0, the standard deviation of the target's pixels in linear RGB")
    default, _ = chosen_camera(scene, camera)
    pictures = files_of_cameras("--target", given, scene.cameras, default)
    mask_files = files_of_cameras("--mask", masks, scene.cameras, default)
    for name, path in mask_files.items():
        if name not in pictures:
            raise InputError(f"--mask {path}: camera {name!r} has no target; there are targets for {', '.join(pictures)}")
    targets = []
    for name, path in pictures.items():
        picture = read_image(path)
        for remark in picture.notes:
            note(f"{path}: {remark}")
        mask = read_mask(mask_files[name]) if name in mask_files else picture.alpha
        if name not in mask_files and mask is not None and not np.all(mask == 1):
            note(f"{path}: its alpha channel is the mask; {np.mean(mask > 0):.0%} of the pixels count")
        targets.append(Target(picture.pixels, name, mask, noise))
    return targets
