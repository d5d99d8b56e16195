"""The fit of a texture as files: its texels and their standard errors as pictures, and numbers on them."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from diffwhitted.records import changed
from diffwhitted.scene import Scene

from .._fit_texture import TextureFit
from ._outputs import suffixes, write_together


def map_summary(result: TextureFit) -> list[str]:
    """What a person wants to know, a sentence a line."""
    lines = [f"texture {result.texture!r}: {result.status}: {result.message}"]
    middle, largest = _spread(result)
    lines.append(f"standard error of a texel: {middle:.3g} in the middle, {largest:.3g} at most")
    lines.append(f"residual: {result.residual:.3g}, root mean square of a channel of a pixel")
    return lines


def map_json(result: TextureFit) -> dict[str, Any]:
    """As JSON values."""
    middle, largest = _spread(result)
    height, width = result.seen.shape
    return {
        "texture": result.texture,
        "status": result.status,
        "message": result.message,
        "texels": {
            "height": height,
            "width": width,
            "seen": int(result.seen.sum()),
            "unseen": int((~result.seen).sum()),
            "negative": int((result.texels < 0).any(axis=-1).sum()),
        },
        "standard_error": {"median": middle, "largest": largest},
        "residual": result.residual,
        "noise": None if np.isnan(result.noise) else result.noise,
        "pixels_left_out_of_standard_errors": result.left_out,
        "steps": result.steps,
        "seconds": result.seconds,
    }


def write_map(
    result: TextureFit,
    folder: Path,
    *,
    save_scene: Callable[[Scene, Path], Any],
    metadata: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Writes `result.json`, `NAME.exr`, `NAME.standard_errors.exr` (NaN where unseen), `fitted.toml`, whose texture is
    `NAME.exr`, and the pictures `render.exr`, with the camera's name where there are several.

    All of one run or none (see `write_together`). Returns the paths in this order; raises `OutputError`.
    """
    from diffwhitted.image import write_image

    # A name may hold what a file's may not.
    name = "".join(c if c.isalnum() or c in "-_" else "_" for c in result.texture)
    content = {**map_json(result), **({"metadata": dict(metadata)} if metadata else {})}

    def scene_file(path: Path) -> None:
        found = result.scene.textures[result.texture]
        named = changed(found, file=str(folder / f"{name}.exr"))
        save_scene(changed(result.scene, textures={**result.scene.textures, result.texture: named}), path)

    jobs: dict[str, Callable[[Path], Any]] = {
        "result.json": lambda path: path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", "utf-8"),
        f"{name}.exr": lambda path: write_image(path, np.asarray(np.maximum(result.texels, 0), np.float32)),
        f"{name}.standard_errors.exr": lambda path: write_image(path, result.standard_errors.astype(np.float32)),
        "fitted.toml": scene_file,
    }
    pictures = zip(result.pictures.values(), suffixes(list(result.pictures)), strict=True)
    for picture, suffix in pictures:
        jobs[f"render{suffix}.exr"] = lambda path, picture=picture: write_image(path, picture.astype(np.float32))
    return write_together(folder, jobs, last="result.json")


def _spread(result: TextureFit) -> tuple[float, float]:
    """The median and the largest standard error of what is seen."""
    errors = result.standard_errors[result.seen]
    return float(np.median(errors)), float(errors.max())
