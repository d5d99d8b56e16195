"""Backgrounds as equirectangular maps in files beside a scene of another program."""

import tempfile
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from ..numerics._vector import vec3
from ..scene import EnvironmentBackground, HarmonicBackground
from ._losses import Losses
from ._numbers import plain

ENDING = "_environment.exr"
"""Of the file of the map, after the name of the scene's own."""
SMOOTH = 128
"""Rows of a map of harmonics: within 1e-3 of their differences."""


def panorama(background: EnvironmentBackground | HarmonicBackground, lost: Losses) -> tuple[np.ndarray, float]:
    """Linear RGB of the whole sphere, (height, 2 height, 3), and the degrees that it is turned by from -z to +x."""
    if isinstance(background, EnvironmentBackground):
        return plain(background.texels) * float(plain(background.scale)), float(plain(background.rotation_deg))
    polar = (np.arange(SMOOTH)[:, None] + 0.5) * np.pi / SMOOTH
    azimuth = (np.arange(2 * SMOOTH) + 0.5) * np.pi / SMOOTH - np.pi
    towards = [np.sin(polar) * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -np.sin(polar) * np.cos(azimuth)]
    texels = np.asarray(background.seen(vec3(jnp.asarray(np.stack(towards, axis=-1)))).stacked(), np.float64)
    lost.say(f"the harmonics of the background are a map of {2 * SMOOTH} x {SMOOTH} texels")
    if (texels < 0).any():
        lost.say("where the background is below 0 it is 0")
    return np.maximum(texels, 0), 0.0


def exr_file(texels: np.ndarray) -> bytes:
    """The bytes of an OpenEXR file with these texels, 32 bit floats."""
    from ..image import write_image  # OpenImageIO takes long to load

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.exr"
        write_image(path, texels)
        return path.read_bytes()
