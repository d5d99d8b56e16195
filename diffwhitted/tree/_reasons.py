"""Why a scene calls for an effect, and why one is off whatever calls for it, in words."""

from collections.abc import Callable

import jax
import numpy as np

from ..scene import AbstractLight, Material, is_traced, most_ambient
from ..shapes import AbstractObject
from ._asked import Asked, frees_ambient

Reason = Callable[[Asked], str | None]


def with_coefficient(coefficient: str) -> Reason:
    return lambda asked: asked.first_with(coefficient)


def dark(asked: Asked) -> str | None:
    return None if asked.scene.lights else "the scene has no light"


def no_light_around(asked: Asked) -> str | None:
    return None if asked.scene.background.lights_surfaces else "the background lights no surface"


def shiny(asked: Asked) -> str | None:
    def why(name: str) -> str | None:
        stated = asked.scene.materials[name].is_shiny or f"{name}.k_h" in asked.free
        return asked.reasons.get((name, "k_h")) if stated else None

    return asked.first_made_of(why)


def flat(asked: Asked) -> str | None:
    return None if asked.depth > 1 else "max_depth = 1: camera rays only"


def between_surfaces(asked: Asked) -> str | None:
    reason = asked.first_with("k_d")
    return None if asked.scene.radiosity is None or reason is None else f"radiosity, {reason}"


def not_between_surfaces(asked: Asked) -> str | None:
    return "no radiosity" if asked.scene.radiosity is None else None


def no_ambient(asked: Asked) -> str | None:
    if asked.scene.radiosity is not None:
        return "radiosity stands in its place"
    ambient = most_ambient(asked.scene.ambient)
    if frees_ambient(asked.free):
        return None
    return "ambient = 0" if not is_traced(ambient) and not np.any(np.asarray(ambient) > 0) else None


def caster(asked: Asked) -> str | None:
    objects = asked.scene.objects
    if len(objects) == 1 and objects[0].FLAT:
        return None
    others = " and others" if len(objects) > 1 else ""
    return f"object {objects[0].name!r}{others} can block a light" if objects else None


def no_shadows(asked: Asked) -> str | None:
    return 'shadows = "off"' if asked.scene.shadows == "off" else None


def not_tinted(asked: Asked) -> str | None:
    return None if asked.scene.shadows == "tinted" else f'shadows = "{asked.scene.shadows}"'


def denser(asked: Asked) -> str | None:
    for thing in asked.users("k_t"):
        index, name = asked.scene.materials[thing.material].refractive_index, f"{thing.material}.refractive_index"
        if is_traced(index) or name in asked.free:
            return f"object {thing.name!r}: {name} may be anything"
        if float(index) > 1:
            return f"object {thing.name!r}: {name} = {float(index):g}"
    return None


def second_glass(asked: Asked) -> str | None:
    glass = asked.users("k_t")
    if not any(thing.solid for thing in glass):
        return None
    if len(glass) > 1:
        return f"objects {glass[0].name!r} and {glass[1].name!r} are both transparent"
    others = [thing for thing in asked.scene.objects if thing is not glass[0]]
    if coat := next((thing for thing in others if _looks_at_indices(asked, thing.material)), None):
        return f"object {coat.name!r} may stand in {glass[0].name!r}, whose index counts"
    if absorbing(asked) and (within := next((thing for thing in others if _may_overlap(glass[0], thing)), None)):
        return f"object {within.name!r} may stand in {glass[0].name!r}, which absorbs light"
    return None


def _may_overlap(glass: AbstractObject, thing: AbstractObject) -> bool:
    """May part of a thing lie in the glass? As far as a bounding sphere and a plane tell."""
    if any(map(is_traced, jax.tree.leaves((glass, thing)))):
        return True
    middle, radius = glass.ball()
    return not thing.away_from(middle) >= radius * (1 + 1e-6)


def touching(asked: Asked) -> str | None:
    sheets = asked.sheets
    return f"objects {sheets[0][0][0]!r} and {sheets[0][1][0]!r} share a surface" if sheets else None


def textured(asked: Asked) -> str | None:
    def why(name: str) -> str | None:
        worn = (pair for pair in asked.scene.materials[name].textures if asked.reasons.get((name, pair[0])))
        return next((f"{coefficient}_texture = {texture!r}" for coefficient, texture in worn), None)

    return asked.first_made_of(why)


def interpolated(shading: str) -> Reason:
    def reason(asked: Asked) -> str | None:
        things = (thing for thing in asked.scene.objects if type(thing).INTERPOLATES)
        named = (thing.name for thing in things if thing.interpolation == shading)
        return next((f'object {name!r}: shading = "{shading}"' for name in named), None)

    return reason


def with_light(which: Callable[[AbstractLight], bool], what: str) -> Reason:
    """Some light is such; `what` follows its number."""

    def reason(asked: Asked) -> str | None:
        numbers = (number for number, light in enumerate(asked.scene.lights, 1) if which(light))
        return next((f"light {number} {what}" for number in numbers), None)

    return reason


def with_lens(asked: Asked) -> str | None:
    """Some camera has a lens."""
    return _of_a_camera(asked, "aperture")


def moving(asked: Asked) -> str | None:
    """Some camera's shutter is open for a while."""
    return _of_a_camera(asked, "shutter")


def at_rest(asked: Asked) -> str | None:
    """Nothing moves."""
    of_it = [velocity for thing in (*asked.scene.objects, *asked.cameras) if (velocity := thing.velocity) is not None]
    free = any(".velocity" in name for name in asked.free)
    return None if free or any(is_traced(v) or np.any(v) for v in of_it) else "no object or camera has a velocity"


def _of_a_camera(asked: Asked, key: str) -> str | None:
    """Why a number of some camera is at work."""
    if any(name.startswith("camera.") and name.endswith(f".{key}") for name in asked.free):
        return f"{key} is free in the fit"
    for value in (stated for camera in asked.cameras if (stated := getattr(camera, key)) is not None):
        if is_traced(value):
            return f"{key} is traced and may be anything"
        if float(value) > 0:
            return f"a camera has {key} = {float(value):.4g}"
    return None


def gradient(asked: Asked) -> str | None:
    return "background = { gradient = ... }" if asked.scene.background.varies else None


def truncated(asked: Asked) -> str | None:
    cutoff = asked.scene.cutoff
    if is_traced(cutoff):
        return "cutoff is traced and may be anything"
    return f"cutoff = {float(cutoff):.4g}" if float(cutoff) > 0 else None


def with_fresnel(model: str) -> Reason:
    """Some object's branches are weighed by this model of the angle."""

    def reason(asked: Asked) -> str | None:
        def why(name: str) -> str | None:
            material = asked.scene.materials[name]
            return _chosen(material) if material.fresnel_model == model and _splits(asked, name) else None

        return asked.first_made_of(why)

    return reason


def _chosen(material: Material) -> str:
    kind = "" if material.class_ == "whitted" else f'class = "{material.class_}", '
    return f'{kind}fresnel = "{material.fresnel}"'


def _splits(asked: Asked, material: str) -> bool:
    return any(asked.reasons.get((material, name)) for name in ("k_s", "k_t"))


def coated(asked: Asked) -> str | None:
    """Some object is polished."""
    polished = 'class = "polished"'
    return asked.first_made_of(lambda name: polished if asked.scene.materials[name].class_ == "polished" else None)


def weighed_highlight(asked: Asked) -> str | None:
    """Some object's highlight is weighed by the angle."""

    def why(name: str) -> str | None:
        weighed = asked.scene.materials[name].fresnel_highlight and asked.reasons.get((name, "k_h"))
        return "fresnel_highlight = true" if weighed else None

    return asked.first_made_of(why)


def absorbing(asked: Asked) -> str | None:
    """Some object absorbs light on its way inside."""

    def why(name: str) -> str | None:
        return asked.reasons.get((name, "extinction")) if asked.reasons.get((name, "k_t")) else None

    return asked.first_made_of(why)


def _looks_at_indices(asked: Asked, name: str) -> bool:
    """Is a material opaque, and what it sends back hangs on what it stands in?"""
    material = asked.scene.materials[name]
    bent = material.fresnel_model in ("exact", "schlick") and (material.fresnel_highlight or _splits(asked, name))
    return bent and not asked.reasons.get((name, "k_t"))


def dispersing(asked: Asked) -> str | None:
    """Some object's index hangs on the wavelength, and is looked at."""

    def why(name: str) -> str | None:
        material = asked.scene.materials[name]
        if not (asked.reasons.get((name, "k_t")) or _looks_at_indices(asked, name)):
            return None
        if material.curve:
            return f"dispersion = {material.dispersion}"
        return f"{name}.abbe_number" if "abbe_number" in material.switched else None

    return asked.first_made_of(why)


def one_band(asked: Asked) -> str | None:
    return "bands = 1" if asked.scene.bands == 1 else None


def wrinkled(asked: Asked) -> str | None:
    """Some object's normals are bent."""

    def why(name: str) -> str | None:
        material = asked.scene.materials[name]
        return f'{material.relief[0][0]} = "{material.relief[0][1]}"' if material.is_wrinkled else None

    return asked.first_made_of(why)


def rough(asked: Asked) -> str | None:
    """Some object sends its rays on along normals that vary."""

    def why(name: str) -> str | None:
        return f"{name}.roughness" if asked.scene.materials[name].is_rough and _splits(asked, name) else None

    return asked.first_made_of(why)
