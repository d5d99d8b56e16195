"""Materials whose angle is reckoned in another way, or that are averaged over another number of normals."""

from collections.abc import Iterator

from ..records import changed
from ..scene import Material, Scene

CONVERGED_ROUGHNESS_SAMPLES = 16
"""Normals a tree of a rough surface, in a reference, whose trees have normals of their own."""
BOTH = ("exact", "schlick")
"""The models of Fresnel's reflectance that stand in for each other."""


def has_fresnel(scene: Scene) -> bool:
    """Is some material's reflectance that of a dielectric, by either model?"""
    return any(map(_weighed, _used(scene)))


def has_gloss(scene: Scene) -> bool:
    """Is some material rough?"""
    return any(material.is_rough for material in _used(scene))


def with_materials(scene: Scene, fresnel: str | None, roughness_samples: int | None) -> Scene:
    """The scene with this model of Fresnel's reflectance and so many samples of what is rough; None leaves either."""

    def made(material: Material) -> Material:
        if fresnel is not None and _weighed(material):
            material = changed(material, fresnel=fresnel)
        if roughness_samples is not None and material.is_rough:
            material = changed(material, roughness_samples=roughness_samples)
        return material

    if fresnel is None and roughness_samples is None:
        return scene
    return changed(scene, materials={name: made(material) for name, material in scene.materials.items()})


def _weighed(material: Material) -> bool:
    """Polished materials know one model only, and metals none of the two."""
    return material.fresnel_model in BOTH and set(BOTH) <= {*material.kind.fresnel}


def _used(scene: Scene) -> Iterator[Material]:
    return (scene.materials[name] for name in {thing.material for thing in scene.objects})
