"""What some effects make, at most, of the coefficients of a material; and scenes without the shading of others."""

from collections.abc import Callable

import numpy as np

from ..illumination import polished_most
from ..records import changed
from ..scene import Scene


def most_when_polished(scene: Scene, name: str, most: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    material = scene.materials[name]
    return polished_most(most, float(material.refractive_index)) if material.class_ == "polished" else most


def most_of_metal(scene: Scene, name: str, most: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return most | {"k_h": np.maximum(most["k_h"], 1)} if scene.materials[name].fresnel_model == "metal" else most


def by_phong(shading: str) -> Callable[[Scene], Scene]:
    """The scene with interpolated normals in place of such shading."""

    def without(scene: Scene) -> Scene:
        things = (thing.shaded("phong") if thing.interpolation == shading else thing for thing in scene.objects)
        return changed(scene, objects=tuple(things))

    return without
