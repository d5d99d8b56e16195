"""Targets: what a camera saw, how much each pixel counts, and how noisy it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diffwhitted.scene import Scene, nearest_name

from .._errors import FitError


@dataclass(frozen=True, eq=False)
class Target:
    """One picture to fit.

    - `image`: `(H, W, 3)`, linear Rec. 709 RGB, the size of the camera.
    - `camera`: name of the camera in the scene; None: the only one, or "main".
    - `mask`: `(H, W)` in [0, 1], how much each pixel counts; None: all alike. Pixels with 0 may hold anything.
    - `noise`: standard deviation of the pixel values, one number or `(H, W)`; None: estimated from what
      the fit leaves over.
    """

    image: np.ndarray
    camera: str | None = None
    mask: np.ndarray | None = None
    noise: float | np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class CheckedTarget:
    """A target that fits its scene, with nothing left to guess; `noise` is that of each pixel, None: unknown."""

    image: np.ndarray
    camera: str
    mask: np.ndarray
    noise: np.ndarray | None


def as_targets(scene: Scene, targets) -> tuple[CheckedTarget, ...]:
    """One picture, one `Target`, a mapping from cameras to pictures, or a sequence of targets, checked.

    Raises `FitError` naming the camera for an unknown camera, another size, pixels that are not finite, a mask
    outside [0, 1] or empty, a noise that is not positive, codes in place of light, and two cameras for one target.
    """
    if isinstance(targets, Mapping):
        targets = [_of_camera(camera, target) for camera, target in targets.items()]
    elif isinstance(targets, Target) or not isinstance(targets, Sequence):
        targets = [targets]
    targets = [t if isinstance(t, Target) else Target(np.asarray(t)) for t in targets]
    if not targets:
        raise FitError("targets: there is none; give at least one picture")
    checked = tuple(_checked(scene, target) for target in targets)
    if len({t.noise is None for t in checked}) > 1:
        raise FitError("targets: some have a noise and some do not; give it for all of them or for none")
    return checked


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


def _checked(scene: Scene, target: Target) -> CheckedTarget:
    name = _camera_name(scene, target.camera)
    camera, place = scene.cameras[name], f"target of camera {name!r}"
    size = (camera.height, camera.width)
    image = np.asarray(target.image)
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
    mask = np.ones(size) if target.mask is None else np.asarray(target.mask, np.float64)
    if mask.shape != size:
        raise FitError(f"{place}: the mask has shape {mask.shape}; allowed is {size}, one value a pixel")
    if not np.all((mask >= 0) & (mask <= 1)):
        raise FitError(
            f"{place}: the mask goes from {np.min(mask):g} to {np.max(mask):g}; allowed is 0 (ignore) to 1 (use)"
        )
    if not mask.any():
        raise FitError(f"{place}: the mask leaves no pixel to fit; set some of it to 1")
    bad = ~np.isfinite(image).all(axis=2) & (mask > 0)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise FitError(
            f"{place}: {bad.sum()} pixel(s) are NaN or infinite, the first in row {row}, column {column}; "
            "mask them (mask 0), or repair the picture"
        )
    image = np.where((mask > 0)[..., None], image, 0)
    return CheckedTarget(image, name, mask, _checked_noise(target.noise, size, place))


def _camera_name(scene: Scene, name: str | None) -> str:
    if not scene.cameras:
        raise FitError("targets: the scene has no camera; add a [[camera]]")
    if name is None:
        name = "main" if "main" in scene.cameras or len(scene.cameras) > 1 else next(iter(scene.cameras))
    if name not in scene.cameras:
        raise FitError(
            f"targets: no camera {name!r}; there is {', '.join(scene.cameras)}.{nearest_name(name, scene.cameras)}"
        )
    return name


def _checked_noise(noise, size: tuple[int, int], place: str) -> np.ndarray | None:
    if noise is None:
        return None
    noise = np.asarray(noise, np.float64)
    if noise.shape not in ((), size) or not np.all(np.isfinite(noise) & (noise > 0)):
        raise FitError(
            f"{place}: the noise must be a standard deviation > 0, one number or one a pixel; it has shape "
            f"{noise.shape} and goes down to {np.min(noise):g}"
        )
    return np.broadcast_to(noise, size)
