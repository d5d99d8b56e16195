"""Targets: what a camera saw, how much each pixel counts, and how noisy it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeGuard

import numpy as np

from diffwhitted import SceneError, Shot
from diffwhitted.records import changed
from diffwhitted.scene import Scene, nearest_name

from .._errors import FitError
from ._noise import Noise, checked_noise

if TYPE_CHECKING:
    from diffwhitted.image import ImageFile

FEW = 0.001
"""Share of the pixels up to which clipped ones stay in the fit."""


@dataclass(frozen=True, eq=False)
class Target:
    """One picture to fit.

    - `image`: `(H, W, 3)`, linear Rec. 709 RGB, the size of the camera, taken as exact; or what `read_image` gives,
      with all that its file says: the width of a code, alpha, clipping.
    - `camera`: name of the camera in the scene; None: the only one, or "main".
    - `mask`: `(H, W)` in [0, 1], how much each pixel counts; None: the alpha of the file, or all alike. Pixels with 0
      may hold anything.
    - `noise`: standard deviation of the pixel values, one number, `(H, W)` or `(H, W, 3)`; (read, gain) for variance =
      read^2 + gain * value; None: estimated from what the fit leaves over.
    - `name`: by which its numbers are free ("shot.NAME.exposure"); None: that of its camera.
    - `shot`: exposure, black level, lights that burn, filter (see `diffwhitted.Shot`); None: light as it is.
    - `keep_clipped`: use pixels at the largest code of a file too, which are masked where there are many.
    - `skip_bad_pixels`: leave out pixels that are NaN or infinite, and say how many, in place of an error.
    """

    image: "np.ndarray | ImageFile"
    camera: str | None = None
    mask: np.ndarray | None = None
    noise: float | np.ndarray | tuple[float, float] | None = None
    name: str | None = None
    shot: Shot | None = None
    keep_clipped: bool = False
    skip_bad_pixels: bool = False


@dataclass(frozen=True, eq=False)
class CheckedTarget:
    """A target that fits its scene, with nothing left to guess; `noise` is that of each pixel, None: unknown."""

    image: np.ndarray
    camera: str
    mask: np.ndarray
    noise: Noise | None
    shot: Shot
    monochrome: bool = False
    """Its three channels are one measurement."""
    file: "ImageFile | None" = None
    notes: tuple[str, ...] = ()
    """What a user should know of how it was read."""

    @property
    def name(self) -> str:
        return self.shot.name

    @property
    def channels(self) -> int:
        """Measurements a pixel."""
        return 1 if self.monochrome else 3


def as_targets(scene: Scene, targets) -> tuple[CheckedTarget, ...]:
    """One picture, one `Target`, a mapping from cameras to pictures, or a sequence of targets, checked.

    Raises `FitError` naming the camera for an unknown camera, another size, pixels that are not finite, a mask
    outside [0, 1] or empty, a noise that is not positive, codes in place of light, and two targets of one name.
    """
    if isinstance(targets, Mapping):
        targets = [_of_camera(camera, target) for camera, target in targets.items()]
    elif isinstance(targets, Target) or not isinstance(targets, Sequence):
        targets = [targets]
    targets = [t if isinstance(t, Target) else Target(t if is_file(t) else np.asarray(t)) for t in targets]
    if not targets:
        raise FitError("targets: there is none; give at least one picture")
    names = _names(scene, targets)
    checked = tuple(_checked(scene, target, name) for target, name in zip(targets, names, strict=True))
    if len({t.noise is None for t in checked}) > 1:
        raise FitError("targets: some have a noise and some do not; give it for all of them or for none")
    return checked


def residual_count(targets: Sequence[CheckedTarget]) -> int:
    """Measurements in all."""
    return sum(t.channels * int((t.mask > 0).sum()) for t in targets)


def is_file(image) -> "TypeGuard[ImageFile]":
    """Is it a picture as `read_image` gives it? The library of image files is loaded for those alone."""
    return type(image).__name__ == "ImageFile"


def _names(scene: Scene, targets: Sequence[Target]) -> list[str]:
    """The name of each: its own, that of its shot, or of its camera, numbered where a camera took several pictures."""
    cameras = [camera_name(scene, t.camera or (t.shot and t.shot.camera)) for t in targets]
    given = [t.name or (t.shot and t.shot.name) for t in targets]
    names = []
    for camera, name in zip(cameras, given, strict=True):
        count = names.count(camera) + sum(other.startswith(f"{camera}_") for other in names)
        names.append(name or (camera if not count else f"{camera}_{count + 1}"))
    for name in names:
        if names.count(name) > 1:
            raise FitError(f"targets: two are called {name!r}; give each a name of its own")
    return names


def _of_camera(camera: str, target) -> Target:
    """The target of one entry of a mapping."""
    if not isinstance(target, Target):
        return Target(target, camera)
    if target.camera not in (None, camera):
        raise FitError(
            f"targets: the target at {camera!r} names the camera {target.camera!r}; leave one of the two out, or "
            "make them agree"
        )
    return replace(target, camera=camera)


def _checked(scene: Scene, target: Target, called: str) -> CheckedTarget:
    name = camera_name(scene, target.camera or (target.shot and target.shot.camera))
    camera, place = scene.cameras[name], f"target of camera {name!r}"
    size = (camera.height, camera.width)
    # Take what the file says of itself.
    file = target.image if is_file(target.image) else None
    image = np.asarray(target.image if file is None else file.pixels)
    given_mask = target.mask if target.mask is not None or file is None else file.alpha
    if image.ndim != 3 or image.shape[2] != 3:
        raise FitError(f"{place}: its shape is {image.shape}; allowed is (height, width, 3), linear RGB")
    if not np.issubdtype(image.dtype, np.floating):
        raise FitError(
            f"{place}: its values are of type {image.dtype}; allowed is linear light as floating-point numbers. "
            "Of 8-bit codes use diffwhitted.read_image, or divide and linearise"
        )
    if image.shape[:2] != size:
        raise FitError(
            f"{place}: the picture has {image.shape[1]}x{image.shape[0]} pixels, the camera "
            f"{camera.width}x{camera.height}; set the camera's width and height to the picture's, or resize the picture"
        )
    mask = np.ones(size) if given_mask is None else np.asarray(given_mask, np.float64)
    if mask.shape != size:
        raise FitError(f"{place}: the mask has shape {mask.shape}; allowed is {size}, one value a pixel")
    if not np.all((mask >= 0) & (mask <= 1)):
        raise FitError(
            f"{place}: the mask goes from {np.min(mask):g} to {np.max(mask):g}; allowed is 0 (ignore) to 1 (use)"
        )
    if not mask.any():
        raise FitError(f"{place}: the mask leaves no pixel to fit; set some of it to 1")
    notes = []
    if file is not None and not target.keep_clipped:
        mask = _without_clipped(file, mask, notes)
    bad = ~np.isfinite(image).all(axis=2) & (mask > 0)
    if bad.any() and target.skip_bad_pixels and not bad[mask > 0].all():
        mask = np.where(bad, 0, mask)
        notes.append(f"{place}: {bad.sum()} pixel(s) are NaN or infinite and were left out")
    elif bad.any():
        row, column = np.argwhere(bad)[0]
        raise FitError(
            f"{place}: {bad.sum()} pixel(s) are NaN or infinite, the first in row {row}, column {column}; "
            "mask them (mask 0; diffwhitted fit --skip-bad-pixels), or repair the picture"
        )
    image = np.where((mask > 0)[..., None], image, 0)
    noise = target.noise if target.noise is not None or target.shot is None else target.shot.noise
    monochrome = bool((image == image[..., :1]).all() and image.any()) or (file is not None and file.monochrome)
    try:
        shot = _named(target.shot, called, scene)
    except SceneError as error:
        raise FitError(f"targets: {error}") from None
    return CheckedTarget(image, name, mask, checked_noise(noise, size, place), shot, monochrome, file, tuple(notes))


def _without_clipped(file: "ImageFile", mask: np.ndarray, notes: list[str]) -> np.ndarray:
    """The mask without the pixels that are clipped, which may have been any amount brighter; as it is where they are
    few.
    """
    clipped = file.clipped
    if clipped is None or clipped.mean() <= FEW:
        return mask
    notes.append(
        f"{file.path}: {clipped.sum():,} of {clipped.size:,} pixels are clipped (a channel has its "
        "largest code) and are masked; --keep-clipped uses them"
    )
    left = np.where(clipped, 0, mask)
    return left if left.any() else mask


def _named(shot: Shot | None, name: str, scene: Scene) -> Shot:
    """The shot of a target, checked against the scene."""
    if shot is None:
        return Shot(name.replace(".", "_"))
    shot.check(scene.cameras, [light.name or "" for light in scene.lights])
    return changed(shot, name=name)


def camera_name(scene: Scene, name: str | None) -> str:
    """The camera of that name; without one "main", or the only one. Raises `FitError` where there is none."""
    if not scene.cameras:
        raise FitError("targets: the scene has no camera; add a [[camera]]")
    if name is None:
        name = "main" if "main" in scene.cameras or len(scene.cameras) > 1 else next(iter(scene.cameras))
    if name not in scene.cameras:
        raise FitError(
            f"targets: no camera {name!r}; there is {', '.join(scene.cameras)}.{nearest_name(name, scene.cameras)}"
        )
    return name
