"""Which effects a scene calls for, and why.

An effect that is off is not compiled. An effect is on when some coefficient calls for it: because its value
is not zero, because a fit leaves it free, or because it is traced by `jit`, `grad` or `vmap` and so may be
anything.
"""

from collections.abc import Collection
from dataclasses import dataclass, fields

import numpy as np

from ..scene import GradientBackground, Plane, PointLight, Scene, is_traced


@dataclass(frozen=True)
class Effects:
    """One switch an effect; hashable, so that it selects the compiled program."""

    ambient: bool
    diffuse: bool
    highlight: bool
    shadows: bool
    tinted_shadows: bool
    reflection: bool
    refraction: bool
    total_internal_reflection: bool
    nested_media: bool
    textures: bool
    attenuation: bool
    background_gradient: bool
    footprint: bool
    cutoff: bool

    @property
    def branching(self) -> bool:
        """Does any ray have children?"""
        return self.reflection or self.refraction

    @property
    def lighting(self) -> bool:
        """Does any light have to be looked at?"""
        return self.diffuse or self.highlight


EFFECT_NAMES = tuple(field.name for field in fields(Effects))


@dataclass(frozen=True)
class Decision:
    """One effect, on or off, and the reason in words."""

    name: str
    on: bool
    why: str


def calls_for(scene: Scene, material: str, coefficient: str, free: Collection[str] = ()) -> str | None:
    """Why a coefficient of a material is at work ("glass.k_t = 0.7", "... is free"), or None if it is zero."""
    record, name = scene.materials[material], f"{material}.{coefficient}"
    if coefficient == "k_h":
        if record.highlight == "off":
            return None
        if record.k_h is None and f"{material}.k_s" in free:
            return f"{material}.k_s is free and gives k_h"
    value = record.highlight_coefficient() if coefficient == "k_h" else getattr(record, coefficient)
    if name in free:
        return f"{name} is free in the fit"
    if is_traced(value):
        return f"{name} is traced and may be anything"
    if not np.any(np.asarray(value) > 0):
        return None
    return f"{name} = {np.array2string(np.asarray(value), precision=4, separator=', ', legacy=False)}"


def decide_effects(
    scene: Scene, free: Collection[str] = (), max_depth: int | None = None, footprint: int | None = None
) -> tuple[Decision, ...]:
    """Decide every effect for a scene and the free coefficients of a fit, in the order of `Effects`.

    `max_depth` and `footprint` replace the scene's.
    """
    trees = scene.footprint if footprint is None else footprint
    depth = scene.max_depth if max_depth is None else max_depth
    first_with = {name: _first_object(scene, name, free) for name in ("k_a", "k_d", "k_h", "k_s", "k_t")}
    dark = "" if scene.lights else "the scene has no light"
    flat = "" if depth > 1 else "max_depth = 1: camera rays only"
    found = {
        "ambient": _decide(first_with["k_a"], "no object has k_a > 0", _no_ambient(scene)),
        "diffuse": _decide(first_with["k_d"], "no object has k_d > 0", dark),
        "highlight": _decide(first_with["k_h"], "no object has k_h > 0 with a highlight", dark),
        "reflection": _decide(first_with["k_s"], "no object has k_s > 0", flat),
        "refraction": _decide(first_with["k_t"], "no object has k_t > 0", flat),
    }
    lit = found["diffuse"][0] or found["highlight"][0]
    found["shadows"] = _decide(
        _caster(scene),
        "no object can stand between a point and a light",
        'shadows = "off"' if scene.shadows == "off" else "" if lit else "no light is looked at",
    )
    found["tinted_shadows"] = _decide(
        first_with["k_t"],
        "no object has k_t > 0",
        ""
        if scene.shadows == "tinted" and found["shadows"][0]
        else f'shadows = "{scene.shadows}"'
        if scene.shadows != "tinted"
        else "no shadow ray is cast",
    )
    refraction_off = "" if found["refraction"][0] else "no refraction"
    found["total_internal_reflection"] = _decide(
        _denser(scene, free), "every transparent object has index 1", refraction_off
    )
    found["nested_media"] = _decide(_second_glass(scene, free), "fewer than two transparent solids", refraction_off)
    found["textures"] = _decide(_textured(scene, free), "no coefficient in use has a texture")
    found["attenuation"] = _decide(
        _faded(scene), "no point light has an attenuation", "" if lit else "no light is looked at"
    )
    gradient = isinstance(scene.background, GradientBackground)
    found["background_gradient"] = (
        gradient,
        "background = { gradient = ... }" if gradient else "the background is one colour",
    )
    found["cutoff"] = _decide(
        _truncated(scene),
        "cutoff = 0",
        "" if found["reflection"][0] or found["refraction"][0] else "no ray is reflected or refracted",
    )
    found["footprint"] = bool(trees), f"footprint = {trees}"
    return tuple(Decision(name, *found[name]) for name in EFFECT_NAMES)


def as_effects(decisions: tuple[Decision, ...]) -> Effects:
    return Effects(**{d.name: d.on for d in decisions})


def _decide(reason: str | None, otherwise: str, forbidden: str = "") -> tuple[bool, str]:
    if forbidden:
        return False, forbidden
    return (False, otherwise) if reason is None else (True, reason)


def _first_object(scene: Scene, coefficient: str, free) -> str | None:
    for thing in scene.objects:
        reason = calls_for(scene, thing.material, coefficient, free)
        if reason:
            return f"object {thing.name!r}: {reason}"
    return None


def _no_ambient(scene: Scene) -> str:
    dark = not is_traced(scene.ambient) and not np.any(np.asarray(scene.ambient) > 0)
    return "ambient = 0" if dark else ""


def _caster(scene: Scene) -> str | None:
    if len(scene.objects) == 1 and isinstance(scene.objects[0], Plane):
        return None
    return f"object {scene.objects[0].name!r} and others can block a light" if scene.objects else None


def _denser(scene: Scene, free) -> str | None:
    for thing in scene.objects:
        if calls_for(scene, thing.material, "k_t", free):
            index, name = scene.materials[thing.material].refractive_index, f"{thing.material}.refractive_index"
            if is_traced(index) or name in free:
                return f"object {thing.name!r}: {name} may be anything"
            if float(index) > 1:
                return f"object {thing.name!r}: {name} = {float(index):g}"
    return None


def _second_glass(scene: Scene, free) -> str | None:
    glass = [o for o in scene.objects if calls_for(scene, o.material, "k_t", free)]
    solids = [o for o in glass if not hasattr(o, "vertices")]
    if not solids or len(glass) < 2:
        return None
    return f"objects {glass[0].name!r} and {glass[1].name!r} are both transparent"


def _textured(scene: Scene, free) -> str | None:
    for thing in scene.objects:
        material = scene.materials[thing.material]
        for coefficient, texture in (("k_a", material.k_a_texture), ("k_d", material.k_d_texture)):
            if texture is not None and calls_for(scene, thing.material, coefficient, free):
                return f"object {thing.name!r}: {coefficient}_texture = {texture!r}"
    return None


def _truncated(scene: Scene) -> str | None:
    if is_traced(scene.cutoff):
        return "cutoff is traced and may be anything"
    return f"cutoff = {float(scene.cutoff):.4g}" if float(scene.cutoff) > 0 else None


def _faded(scene: Scene) -> str | None:
    for number, light in enumerate(scene.lights, 1):
        if isinstance(light, PointLight) and light.attenuation is not None:
            return f"light {number} has an attenuation"
    return None
