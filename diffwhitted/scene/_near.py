"""Scenes far from the origin of their coordinates, placed relative to the camera that sees them.

float32 resolves 3 cm at 4e5 m, the size of a map's coordinates. The places of such a scene keep the digits that they
were given with (`Scene.keeps_digits`), and whoever traces it subtracts the place of the camera in float64 first: the
picture is that of the same scene here. Names, files and numbers read back stay in the coordinates of the user.
"""

from typing import TypeVar

import numpy as np

from ..records import changed, in_dtype
from ._scene import Scene
from .cameras import AbstractCamera

R = TypeVar("R")


def near(scene: Scene, camera: AbstractCamera) -> tuple[Scene, AbstractCamera]:
    """The scene and the camera that sees it in the scene's precision, relative to the camera where that is far away.

    The picture does not depend on the origin, so derivatives stay what they are. Only in float32, and only where the
    place of the camera is known; what else is traced moves along. Gives back what it is given where nothing is to be
    done.
    """
    if scene.dtype != np.float32 or not camera.is_far:
        return in_dtype(scene, scene.dtype) if scene.keeps_digits else scene, camera.in_precision(scene.dtype)
    # A place that float32 holds, so that whoever else subtracts it loses nothing.
    origin = np.asarray(camera.look_from).astype(np.float32).astype(np.float64)
    moved = changed(
        scene,
        objects=tuple(thing.moved(-origin) for thing in scene.placed_objects()),
        lights=tuple(light.moved(-origin) for light in scene.lights),
        textures={name: texture.moved(-origin) for name, texture in scene.textures.items()},
        cameras={name: one.moved(-origin) for name, one in scene.cameras.items()},
        keeps_digits=False,
    )
    return in_dtype(moved, scene.dtype), camera.moved(-origin).in_precision(scene.dtype)
