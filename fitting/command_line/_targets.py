"""The pictures of a fit from their files: target, mask or alpha, and noise, by camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from diffwhitted import InputError, Shot
from diffwhitted.image import read_image, read_mask
from diffwhitted.records import changed
from fitting import Target
from fitting.problem._shot_files import shots_of
from fitting.problem._target import as_targets, is_file

from ._named_values import files_of_cameras
from ._options import chosen_camera

if TYPE_CHECKING:
    from pathlib import Path

    from diffwhitted import Scene
    from diffwhitted.image import ImageFile


FEW = 0.001
"""Share of the pixels up to which clipped ones stay in the fit."""


def read_targets(
    scene: Scene,
    given: Sequence[str],
    masks: Sequence[str],
    camera: str | None,
    noise: float | None,
    note: Callable[[str], None],
    keep_clipped: bool = False,
) -> list[Target]:
    """One target for each `[CAMERA=]IMAGE`, its mask from `[CAMERA=]FILE` or from its alpha channel.

    Pixels at the largest code of the file are taken out of the mask where there are many, unless `keep_clipped`.
    `note` is told what a user should know. Raises `InputError` for what cannot be read or paired.
    """
    if noise is not None and not 0 < noise < float("inf"):
        raise InputError(
            f"--noise {noise:g}: allowed is a number > 0, the standard deviation of the target's pixels in linear RGB"
        )
    if scene.shots or not given:
        return _of_shots(scene, given, masks, noise, note, keep_clipped)
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
        picture = read_image(path)
        for remark in picture.notes:
            note(f"{path}: {remark}")
        mask = read_mask(mask_files[name]) if name in mask_files else picture.alpha
        if name not in mask_files and mask is not None and not np.all(mask == 1):
            note(f"{path}: its alpha channel is the mask; {np.mean(mask > 0):.0%} of the pixels count")
        if not keep_clipped:
            mask = _without_clipped(picture, mask, path, note)
        shot = Shot(name.replace(".", "_"), name, str(path), None if name not in mask_files else str(mask_files[name]))
        targets.append(Target(picture, name, mask, noise, shot.name, shot))
    return targets


def with_shots(scene: Scene, targets: Sequence[Target]) -> Scene:
    """The scene with the shots of these targets, whose numbers have names."""
    return changed(scene, shots=tuple(target.shot for target in as_targets(scene, targets)))


def _of_shots(scene, given, masks, noise, note, keep_clipped: bool) -> list[Target]:
    """The shots of the scene as targets. Raises `InputError` where there is none, or a target or mask beside them."""
    if scene.shots and (given or masks):
        option, text = ("--target", given[0]) if given else ("--mask", masks[0])
        raise InputError(
            f"{option} {text}: the scene has [[shot]] tables, whose pictures are fitted; leave {option} out, or "
            "the shots"
        )
    if not scene.shots:
        raise InputError("there is no picture to fit; give one with --target, or a [[shot]] in the scene")
    targets = []
    for target in shots_of(scene, note):
        assert is_file(target.image), "a shot of a scene is read from a file"
        mask = target.mask if target.mask is not None else target.image.alpha
        mask = mask if keep_clipped else _without_clipped(target.image, mask, target.image.path, note)
        targets.append(replace(target, mask=mask, noise=target.noise if noise is None else noise))
    return targets


def _all_named(given: Sequence[str], cameras) -> bool:
    """Does each target name its camera?"""
    return all("=" in text and text.partition("=")[0] in cameras for text in given)


def _without_clipped(
    picture: ImageFile, mask: np.ndarray | None, path: Path, note: Callable[[str], None]
) -> np.ndarray | None:
    """The mask without the pixels that are clipped, which may have been any amount brighter; as it is where they are
    few.
    """
    if (
        picture.clipped is None
        or picture.clipped.mean() <= FEW
        or (mask is not None and mask.shape != picture.clipped.shape)
    ):
        return mask
    note(
        f"{path}: {picture.clipped.sum():,} of {picture.clipped.size:,} pixels are clipped (a channel has its "
        "largest code) and are masked; --keep-clipped uses them"
    )
    return np.where(picture.clipped, 0, 1 if mask is None else mask)
