"""Rows of the table of effects: why light has edges, half shadows, a sky, a fade on its way; a scene without them."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..records import changed
from ..scene import AbstractLight, Hemisphere, Scene, Tables, is_traced
from ._asked import Asked


def hemispherical(asked: Asked) -> str | None:
    return "ambient = { sky = ..., ground = ... }" if isinstance(asked.scene.ambient, Hemisphere) else None


def evenly_lit(scene: Scene) -> Scene:
    return changed(scene, ambient=scene.ambient.even()) if isinstance(scene.ambient, Hemisphere) else scene


def distance_faded(asked: Asked) -> str | None:
    fade = asked.scene.distance_fade
    if fade is None:
        return None
    return "distance_fade is traced" if is_traced(fade) else f"distance_fade = {np.asarray(fade).tolist()}"


def faded_by_distance(tables: Tables, distance: Float[Array, "n"]) -> Float[Array, "n"]:
    """max(0, a + b d), with derivative 0 where it is 0."""
    fade = tables.distance_fade
    left = distance if fade is None else fade[0] + fade[1] * distance
    return jnp.where(left > 0, left, 0)


def most_left(scene: Scene) -> float:
    """Infinite where light grows with the distance."""
    a, b = np.asarray(scene.distance_fade, np.float64)
    return np.inf if b > 0 else max(float(a), 0.0)


def by_one_ray(light: AbstractLight) -> bool:
    """Is it a ball that one ray looks at?"""
    return light.ball_radius() is not None


def hardened(scene: Scene) -> Scene:
    hard = (light.without_size() if by_one_ray(light) else light for light in scene.lights)
    return changed(scene, lights=tuple(hard))
