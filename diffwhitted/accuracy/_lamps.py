"""Lamps with a size, looked at by another number of points."""

from ..records import changed
from ..scene import Scene

CONVERGED_SAMPLES = 256
"""Points of each lamp with a size, in a reference."""


def has_sized_lights(scene: Scene) -> bool:
    """Has any lamp a size?"""
    return any(light.sized for light in scene.lights)


def with_light_samples(scene: Scene, samples: int | None) -> Scene:
    """The scene with so many points for each lamp with a size, 0 for one ray; None leaves it as it is."""
    if samples is None or not has_sized_lights(scene):
        return scene
    return changed(scene, lights=tuple(light.sampled(samples) for light in scene.lights))
