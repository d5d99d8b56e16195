"""What a shot of a scene would show: by its camera, lamps, filter, exposure and encoding."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from diffwhitted import Scene, Shot
    from diffwhitted.scene import AbstractCamera, PixelFilter

    from ._render import Picture

SIDE = 4
"""Points along the side of a pixel under a filter, unless more are asked for."""


def shot_of(scene: Scene, name: str) -> tuple[Scene, Shot, str]:
    """The scene with the lamps of that shot alone, the shot, and the name of its camera. Raises `InputError` where the
    scene has no such shot.
    """
    from diffwhitted import InputError
    from diffwhitted.records import changed
    from diffwhitted.scene import nearest_name

    from ._options import chosen_camera

    shots = {shot.name: shot for shot in scene.shots}
    if name not in shots:
        there = ", ".join(shots) or "none at all; add a [[shot]]"
        raise InputError(f"--shot {name}: there is no such shot; there is {there}.{nearest_name(name, shots)}")
    shot = shots[name]
    scene = changed(scene, lights=tuple(light for light in scene.lights if shot.burns(light.name)))
    return scene, shot, chosen_camera(scene, shot.camera)[0]


def as_shown(pixels: np.ndarray, shot: Shot, codes: bool) -> np.ndarray:
    """What the shot makes of light, (height, width, 3); with `codes` for a file of codes of its encoding, which the
    writer takes for sRGB.
    """
    import jax.numpy as jnp
    import numpy as np

    from diffwhitted.image import decode_signal, encode_signal
    from diffwhitted.scene import from_middle

    height, width = pixels.shape[:2]
    row, column = np.indices((height, width)).reshape(2, -1) + 0.5
    light = jnp.asarray(pixels.reshape(-1, 3).T)
    shown = shot.shown(light, *(jnp.asarray(p, light.dtype) for p in from_middle(column, row, width, height)))
    shown = np.asarray(shown, pixels.dtype).T.reshape(pixels.shape)
    if codes and shot.encoding not in (None, "srgb"):
        shown = decode_signal(np.clip(encode_signal(shown, shot.encoding), 0, 1), "srgb").astype(pixels.dtype)
    return shown


def under_filter(scene: Scene, camera: AbstractCamera, depth: int | None, samples: int, kind: PixelFilter) -> Picture:
    """A picture by points, n x n a pixel, under a reconstruction filter."""
    from diffwhitted.image._filters import filtered

    from ._render import rendered

    side = samples if samples > 1 else SIDE
    fine = rendered(scene, camera.resized(side * camera.width, side * camera.height), depth, 1, 0)
    return replace(fine, pixels=filtered(fine.pixels, side, kind))


def refuse_beside_filter(kind: str, footprint, antialias, tolerance, time_budget) -> None:
    """Raise `InputError` where another way to antialias is asked for beside a filter."""
    from diffwhitted import InputError

    others = {"footprint": footprint, "antialias": antialias, "tolerance": tolerance, "time-budget": time_budget}
    for option, value in others.items():
        if value is not None:
            raise InputError(
                f"--{option} {value} with the filter {kind}: allowed is one way to antialias; a filter takes --samples"
            )
