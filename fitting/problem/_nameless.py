"""The scene and the unknowns of a fit without names and bounds, for its programs.

What a compiled program is known by must not hang on what things are called, or on where an interval ends: another
scene of the same kind takes the same program.
"""

from collections.abc import Iterable
from dataclasses import replace

from diffwhitted.records import changed
from diffwhitted.scene import Scene, Shot, material_names, texture_names

from ._unknowns import Unknown

Names = dict[str, dict[str, str]]
"""By family word, the number in words that stands for each name."""


def numbered_names(scene: Scene) -> Names:
    """A number for each name, in the order in which tables have them."""

    def numbered(names: Iterable[str]) -> dict[str, str]:
        return {name: f"{number:06}" for number, name in enumerate(names)}

    return {
        "material": numbered(material_names(scene)),
        "texture": numbered(texture_names(scene)),
        "object": numbered(thing.name for thing in scene.objects),
        "light": numbered(light.name or "" for light in scene.lights),
        "camera": numbered(scene.cameras),
        "shot": numbered(shot.name for shot in scene.shots),
    }


def nameless_scene(scene: Scene, names: Names) -> Scene:
    """The scene with numbers for names."""

    def textured(material):
        textures, relief = (
            tuple((what, names["texture"][name]) for what, name in worn)
            for worn in (material.textures, material.relief)
        )
        return changed(material, textures=textures, relief=relief)

    return changed(
        scene,
        objects=tuple(
            changed(thing, name=names["object"][thing.name], material=names["material"][thing.material])
            for thing in scene.objects
        ),
        lights=tuple(changed(light, name=names["light"][light.name or ""]) for light in scene.lights),
        materials={names["material"][name]: textured(material) for name, material in scene.materials.items()},
        textures={names["texture"][name]: texture for name, texture in scene.textures.items()},
        cameras={names["camera"][name]: camera for name, camera in scene.cameras.items()},
        shots=tuple(_nameless_shot(shot, names) for shot in scene.shots),
    )


def _nameless_shot(shot: Shot, names: Names) -> Shot:
    """The numbers of a shot alone."""
    nothing = dict.fromkeys(("camera", "picture", "mask", "encoding", "lights", "noise", "filter"))
    return changed(shot, name=names["shot"][shot.name], **nothing)


def without_shots(scene: Scene) -> Scene:
    """What its light depends on."""
    return changed(scene, shots=())


def shots_alone(scene: Scene) -> Scene:
    """What shows light as pictures, and nothing of what there is to see."""
    return changed(scene, objects=(), materials={}, lights=(), cameras={}, textures={})


def nameless_unknowns(unknowns: tuple[Unknown, ...], names: Names, bounded: bool) -> tuple[Unknown, ...]:
    """The unknowns of that scene; their bounds are left out unless a program reads them."""

    def nameless(unknown: Unknown) -> Unknown:
        parameter = unknown.parameter
        owner = names.get(parameter.family, {}).get(parameter.owner, parameter.owner)
        bounds = unknown.bounds if bounded else (0.0, 0.0)
        return replace(unknown, parameter=replace(parameter, owner=owner), bounds=bounds, prior=None, sums=())

    return tuple(map(nameless, unknowns))
