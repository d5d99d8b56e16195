"""Which numbers of a scene can have no effect on its pictures, and why: what a fit had better leave alone."""

from collections.abc import Callable, Collection

import numpy as np

from ..scene import Material, Parameter, Scene, is_traced, most_ambient
from ._asked import calls_for, frees_ambient


def idle(
    scene: Scene,
    parameter: Parameter,
    free: Collection[str] = (),
    max_depth: int | None = None,
    cameras: Collection[str] | None = None,
) -> str | None:
    """Why a number cannot change any picture whatever its value, and what to try; None where it may.

    `free`: names of the parameters that may change beside it; `max_depth` in place of the scene's; `cameras`: those
    that take the pictures, by name (None: all).
    """
    match parameter.family:
        case "material":
            return _coefficient(scene, parameter.owner, parameter.row.name, free, max_depth or scene.max_depth)
        case "light":
            return _light(scene, parameter, free)
        case "object" if scene.radiosity is not None:
            return "form factors of radiosity are made of known places and shapes; leave radiosity out, or fix it"
        case "texture":
            return _texture(scene, parameter.owner, free)
        case "camera" if cameras is not None and parameter.owner not in cameras:
            return f"camera {parameter.owner!r} takes none of the pictures"
        case "scene" if frees_ambient([parameter.name]) and scene.radiosity is not None:
            return "radiosity stands in the place of ambient light; leave one of them out"
        case "scene" if frees_ambient([parameter.name]) and not _used(scene, ("k_a",), free):
            return "no object has k_a > 0; give one a value or free it too"
    return None


def _coefficient(scene: Scene, material: str, coefficient: str, free: Collection[str], max_depth: int) -> str | None:
    """Why a coefficient of a material has no effect."""
    record = scene.materials[material]

    def at_work(other: str) -> bool:
        return calls_for(scene, material, other, free) is not None

    if not any(o.material == material for o in scene.objects):
        return f"no object is made of {material!r}"
    surrounded = scene.background.lights_surfaces
    if coefficient == "k_a" and scene.radiosity is not None:
        return "radiosity stands in the place of ambient light; leave radiosity out, or fix k_a"
    if coefficient == "k_d" and scene.radiosity is not None and _used(scene, ("emission",), free):
        return None
    if coefficient in ("k_d", "k_h", "phong_exponent") and not scene.lights and not surrounded:
        return "the scene has no light; add a [[light]]"
    if coefficient == "phong_exponent" and not scene.lights and record.k_h is None and f"{material}.k_h" not in free:
        return f"the scene has no lamp, and the background lights a highlight only where {material}.k_h is stated"
    if coefficient == "k_a" and not frees_ambient(free) and not _some(most_ambient(scene.ambient)):
        return "ambient = 0; raise it, or fix k_a"
    if coefficient in ("k_h", "phong_exponent") and record.highlight == "off":
        return f'material {material!r} has highlight = "off"; choose "halfway" or "reflected"'
    if coefficient == "phong_exponent" and not at_work("k_h"):
        return f"{material}.k_h = 0, so there is no highlight; give k_h a value or free it too"
    if coefficient in ("refractive_index", "abbe_number") and not (at_work("k_t") or _weighs(record, at_work)):
        return (
            f"{material}.k_t = 0, so no light passes through; give k_t a value or free it too, or write "
            'fresnel = "exact", by which it shows in the mirror ray'
        )
    if coefficient == "abbe_number" and scene.bands == 1:
        return "bands = 1: no dispersion is traced; raise it"
    if coefficient in ("extinction", "abbe_number") and not at_work("k_t"):
        return f"{material}.k_t = 0, so no light passes through; give k_t a value or free it too"
    if coefficient in ("k_t", "refractive_index", "k_s") and max_depth == 1:
        if coefficient == "k_s" and record.k_h is None and record.highlight != "off" and scene.lights:
            return None
        return "max_depth = 1: there are only camera rays; raise max_depth"
    return None


def _weighs(record: Material, at_work: Callable[[str], bool]) -> bool:
    """Does the index show in how much light the surface sends back?"""
    if record.fresnel_model not in ("exact", "schlick"):
        return False
    return record.class_ == "polished" or at_work("k_s") or (record.fresnel_highlight and at_work("k_h"))


def _light(scene: Scene, parameter: Parameter, free: Collection[str]) -> str | None:
    """Why a number of a light has no effect."""
    if not _used(scene, ("k_d", "k_h"), free):
        return "no object has k_d or k_h > 0, so nothing is lit; give one a value or free it too"
    light = next(light for light in scene.lights if light.name == parameter.owner)
    colour = f"light.{parameter.owner}.colour"
    dark = not is_traced(getattr(light, "colour", None)) and not np.any(np.asarray(getattr(light, "colour", 1)) > 0)
    if dark and parameter.name != colour and colour not in free:
        return f"{colour} = 0; give it a value or free it too"
    return None


def _texture(scene: Scene, texture: str, free: Collection[str]) -> str | None:
    """Why a texture has no effect."""
    used = {thing.material for thing in scene.objects}
    if any(texture == worn for name in used for _, worn in scene.materials[name].relief):
        return None
    worn = [
        (name, coefficient)
        for name, material in scene.materials.items()
        if any(o.material == name for o in scene.objects)
        for coefficient, worn in material.textures
        if worn == texture
    ]
    if not worn:
        return f"no object wears texture {texture!r}"
    if not any(calls_for(scene, *pair, free) for pair in worn):
        zero = " and ".join(f"{name}.{coefficient}" for name, coefficient in worn)
        return f"{zero} = 0, so texture {texture!r} multiplies nothing; give it a value or free it too"
    return None


def _used(scene: Scene, coefficients: tuple[str, ...], free: Collection[str]) -> bool:
    """Has any object one of these coefficients at work?"""
    used = {thing.material for thing in scene.objects}
    return any(calls_for(scene, name, coefficient, free) for name in used for coefficient in coefficients)


def _some(colour) -> bool:
    return is_traced(colour) or bool(np.any(np.asarray(colour) > 0))
