"""The shots of a scene as targets: their pictures, masks and noise from files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from diffwhitted import Shot
from diffwhitted.image import read_image, read_mask
from diffwhitted.scene import Scene

from .._errors import FitError
from ._target import Target


def shots_of(scene: Scene, note: Callable[[str], None] = lambda text: None) -> list[Target]:
    """A target for each shot of the scene. Raises `FitError` where there is none, and what reading raises."""
    if not scene.shots:
        raise FitError(
            "there is no picture to fit: the scene has no [[shot]]; add one with picture = FILE, or give a target"
        )
    return [target_of(shot, note) for shot in scene.shots]


def target_of(shot: Shot, note: Callable[[str], None] = lambda text: None) -> Target:
    """A shot with its picture, mask and noise; `note` is told what a user should know."""
    if shot.picture is None:
        raise FitError(f"shot {shot.name!r}: it has no picture; name a file, or hand a target to the fit")
    picture = read_image(shot.picture, encoding=shot.encoding)
    for remark in picture.notes:
        note(f"{shot.picture}: {remark}")
    mask = None if shot.mask is None else read_mask(Path(shot.mask))
    return Target(picture, shot.camera, mask, noise_of(shot), shot.name, shot)


def noise_of(shot: Shot):
    """The noise that a shot states, read where it is a picture of standard deviations."""
    return np.asarray(read_image(shot.noise, encoding="linear").pixels) if isinstance(shot.noise, str) else shot.noise
