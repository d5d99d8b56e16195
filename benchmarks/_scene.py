"""The scene that everything is measured on: three spheres over a checkerboard, two lights."""

from pathlib import Path
from typing import Literal

import equinox as eqx

import diffwhitted
from diffwhitted.scene import Scene

FOLDER = Path(__file__).parent
SCENE_FILE = FOLDER / "three_spheres.toml"
POVRAY_FILE = FOLDER / "three_spheres.pov"
CAMERA = "main"
TARGET_SIZE = (320, 240)

UNKNOWNS = (
    "glass.k_a",
    "glass.k_d",
    "glass.k_h",
    "glass.k_s",
    "glass.k_t",
    "glass.phong_exponent",
    "mirror.k_d",
    "mirror.k_h",
    "mirror.k_s",
    "mirror.phong_exponent",
    "coloured.k_d",
    "coloured.k_h",
    "coloured.k_s",
    "coloured.phong_exponent",
)
"""Coefficients that move no ray and that the picture determines: 18 numbers, since two k_d are linear RGB."""


def three_spheres(size: tuple[int, int] | None = None, precision: Literal["float32", "float64"] = "float32") -> Scene:
    """The scene, its camera with `size` (width, height) in place of the file's 640x480."""
    scene = diffwhitted.load_scene(SCENE_FILE, precision=precision)
    if size is None:
        return scene
    return eqx.tree_at(lambda s: s.cameras[CAMERA], scene, scene.cameras[CAMERA].resized(*size))
