"""The pictures that are planned, as targets of a fit that show what the scene shows."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from diffwhitted import Shot
from diffwhitted.image import read_mask
from diffwhitted.scene import Scene, nearest_name

from .._errors import FitError
from ..problem._only import only_these
from ..problem._shot_files import noise_of
from ..problem._target import CheckedTarget, Target, as_targets, camera_name

ALLOWED = (
    "a standard deviation > 0 of pixel values in linear RGB, (read, gain) for variance = read^2 + gain * value, or a "
    "mapping from shots to these"
)


def planned(
    scene: Scene, noise, cameras: str | Sequence[str] | None = None, objects: str | Sequence[str] = ()
) -> tuple[CheckedTarget, ...]:
    """A target without light for each shot of the scene, or for each of the cameras; `noise`: see `identify`.

    Masks of shots that are there are read. Raises `FitError` where shots and cameras are both given, and for a noise
    that is missing, is none, or is that of an unknown shot.
    """
    if scene.shots and cameras is not None:
        raise FitError(
            "camera: the scene has [[shot]] tables, which say what is taken; leave the camera out, or the shots"
        )
    if scene.shots:
        targets = [_of_shot(scene, shot) for shot in scene.shots]
    else:
        named = [cameras] if cameras is None or isinstance(cameras, str) else list(cameras)
        chosen = [camera_name(scene, name) for name in named]
        targets = [Target(_dark(scene, name), name) for name in dict.fromkeys(chosen)]
    called = [t.name or t.camera or "" for t in targets]
    by_name = noise if isinstance(noise, Mapping) else dict.fromkeys(called, noise)
    for name in by_name:
        if name not in called:
            raise FitError(
                f"noise: there is no shot or camera {name!r}; there is {', '.join(called)}."
                f"{nearest_name(str(name), called)}"
            )
    noisy = []
    for name, target in zip(called, targets, strict=True):
        own = by_name.get(name)
        if own is None and target.shot is not None and target.shot.noise is not None:
            own = noise_of(target.shot)
        if own is None:
            raise FitError(f"noise: {name!r} has none, and without it nothing can be foretold; allowed is {ALLOWED}")
        noisy.append(replace(target, noise=own))
    return as_targets(scene, only_these(scene, noisy, objects) if objects else noisy)


def _of_shot(scene: Scene, shot: Shot) -> Target:
    camera = camera_name(scene, shot.camera)
    mask = read_mask(Path(shot.mask)) if shot.mask is not None and Path(shot.mask).exists() else None
    return Target(_dark(scene, camera), camera, mask, None, shot.name, shot)


def _dark(scene: Scene, camera: str) -> np.ndarray:
    return np.zeros((scene.cameras[camera].height, scene.cameras[camera].width, 3))
