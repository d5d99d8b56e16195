"""The pictures of a fit from their files: target, mask or alpha, and noise, by camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from diffwhitted import InputError, Shot
from diffwhitted.image import read_image, read_mask
from diffwhitted.records import changed
from fitting import Target
from fitting.problem._shot_files import shots_of
from fitting.problem._target import as_targets

from ._named_values import files_of_cameras
from ._options import chosen_camera

if TYPE_CHECKING:
    from diffwhitted import Scene


def read_targets(
    scene: Scene,
    given: Sequence[str],
    masks: Sequence[str],
    camera: str | None,
    noise: str | None,
    note: Callable[[str], None],
    keep_clipped: bool = False,
    skip_bad_pixels: bool = False,
    encoding: str | None = None,
    layer: str | None = None,
) -> list[Target]:
    """One target for each `[CAMERA=]IMAGE`, its mask from `[CAMERA=]FILE` or from its alpha channel; without any, the
    shots of the scene.

    `note` is told what a user should know. Raises `InputError` for what cannot be read or paired.
    """
    sigma = None if noise is None else parsed_noise(noise)
    how = {"keep_clipped": keep_clipped, "skip_bad_pixels": skip_bad_pixels}
    if scene.shots or not given:
        targets = _of_shots(scene, given, masks, note)
        return [replace(t, noise=t.noise if sigma is None else sigma, **how) for t in targets]
    default, _ = (None, None) if camera is None and _all_named(given, scene.cameras) else chosen_camera(scene, camera)
    pictures = files_of_cameras("--target", given, scene.cameras, default)
    mask_files = files_of_cameras("--mask", masks, scene.cameras, default)
    for name, path in mask_files.items():
        if name not in pictures:
            raise InputError(
                f"--mask {path}: camera {name!r} has no target; there are targets for {', '.join(pictures)}"
            )
    targets = []
    for name, path in pictures.items():
        picture = read_image(path, layer=layer, encoding=encoding)
        for remark in picture.notes:
            note(f"{path}: {remark}")
        mask = read_mask(mask_files[name]) if name in mask_files else picture.alpha
        if name not in mask_files and mask is not None and not np.all(mask == 1):
            note(f"{path}: its alpha channel is the mask; {np.mean(mask > 0):.0%} of the pixels count")
        shot = Shot(
            name.replace(".", "_"), name, str(path), None if name not in mask_files else str(mask_files[name]), encoding
        )
        targets.append(Target(picture, name, mask, sigma, shot.name, shot, **how))
    return targets


def parsed_noise(text: str):
    """A standard deviation, (read, gain), or a picture of standard deviations. Raises `InputError` for anything
    else.
    """
    allowed = (
        "allowed is a number > 0, the standard deviation of the target's pixels in linear RGB, read=R,gain=G for "
        "variance = R^2 + G * value, or the file of a picture of standard deviations"
    )
    split = [part.strip().partition("=") for part in text.split(",")]
    parts = {key: value for key, _, value in split}
    try:
        if set(parts) <= {"read", "gain"}:
            read, gain = (float(parts.get(key, 0)) for key in ("read", "gain"))
            good, found = min(read, gain) >= 0 and 0 < read + gain < float("inf"), (read, gain)
        else:
            found = float(text)
            good = 0 < found < float("inf")
    except ValueError:
        if not Path(text).exists():
            raise InputError(f"--noise {text}: {allowed}") from None
        return np.asarray(read_image(text, encoding="linear").pixels)
    if not good:
        raise InputError(f"--noise {text}: {allowed}")
    return found


def with_shots(scene: Scene, targets: Sequence[Target], note: Callable[[str], None]) -> Scene:
    """The scene with the shots of these targets, whose numbers have names."""
    checked = as_targets(scene, targets)
    for remark in (remark for target in checked for remark in target.notes):
        note(remark)
    return changed(scene, shots=tuple(target.shot for target in checked))


def _of_shots(scene, given, masks, note) -> list[Target]:
    """The shots of the scene as targets. Raises `InputError` where there is none, or a target or mask beside them."""
    if scene.shots and (given or masks):
        option, text = ("--target", given[0]) if given else ("--mask", masks[0])
        raise InputError(
            f"{option} {text}: the scene has [[shot]] tables, whose pictures are fitted; leave {option} out, or "
            "the shots"
        )
    if not scene.shots:
        raise InputError("there is no picture to fit; give one with --target, or a [[shot]] in the scene")
    return shots_of(scene, note)


def _all_named(given: Sequence[str], cameras) -> bool:
    """Does each target name its camera?"""
    return all("=" in text and text.partition("=")[0] in cameras for text in given)
