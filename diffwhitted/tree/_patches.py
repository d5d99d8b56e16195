"""Rows of the table of effects: light from patches, and light that a surface sends out of its own."""

import numpy as np

from ..illumination import SurfacePoint
from ..numerics._vector import Vec3
from ..scene import Scene, brightest_patch
from ._surrounded import AROUND


def sent_back_of_patches(point: SurfacePoint) -> Vec3:
    """k_d H / pi, H the light that arrives from diffuse surfaces (Hearn and Baker 14-7)."""
    assert point.gathered is not None, "without radiosity the effect is off"
    return point.gathered * point.colour(AROUND if AROUND in point.coefficients else "k_d")


def brightest_of_patches(scene: Scene, name: str) -> np.ndarray:
    """No surface gets more than the brightest patch sends."""
    k_d, worn = (
        np.asarray(scene.materials[name].values["k_d"], np.float64),
        scene.materials[name].texture_at_work("k_d"),
    )
    share = np.broadcast_to(k_d * (1.0 if worn is None else scene.textures[worn].brightest()), 3)
    return np.where(share > 0, share * brightest_patch(scene), 0.0)


def sent_out(point: SurfacePoint) -> Vec3:
    """Its emission, to all sides."""
    return point.colour("emission")


def sent_out_at_most(scene: Scene, name: str) -> np.ndarray:
    material = scene.materials[name]
    worn = material.texture_at_work("emission")
    most = np.broadcast_to(np.asarray(material.values["emission"], np.float64), 3)
    return np.where(most > 0, most * (1.0 if worn is None else scene.textures[worn].brightest()), 0.0)
