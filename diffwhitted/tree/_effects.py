"""Which effects a scene calls for, and why: one table of effects.

An effect that is off is not compiled. An effect is on when some coefficient calls for it: because its value
is not zero, because a fit leaves it free, or because it is traced by `jit`, `grad` or `vmap` and so may be
anything. A new effect is a row: what calls for it, what it cannot do without, and what it adds to the light of a
point or to the weights of its branches.
"""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from jaxtyping import Array, Int

from ..illumination import SurfacePoint
from ..numerics._vector import Vec3
from ..records import changed
from ..scene import Scene, is_traced
from ._asked import Asked

Reason = Callable[[Asked], str | None]


@dataclass(frozen=True)
class Effect:
    """One row."""

    name: str
    called_for: Reason
    """Why the scene calls for it, or None."""
    otherwise: str
    """Why it is off where nothing calls for it."""
    needs: tuple[tuple[str, ...], str] = ((), "")
    """Effects of which at least one must be on, and what is said where none is."""
    forbidden: Reason = lambda asked: None
    """Why it is off whatever calls for it, or None."""
    without: Callable[[Scene], Scene] = lambda scene: scene
    """The scene without what it shows, where it takes more than to leave it out of the program."""
    coefficients: tuple[str, ...] = ()
    """Those that it adds to a point, beside Whitted's."""
    adds: Callable[[SurfacePoint], Vec3] | None = None
    """Light that a point sends back whatever lamps do."""
    weighs: Callable[[SurfacePoint, Int[Array, "n"], Vec3], Vec3] | None = None
    """What it makes of the weight of a branch."""
    brightest: Callable[[Scene, str], np.ndarray] | None = None
    """The most light that it adds at a point of a material (by name), (3,); None: no finite amount is known."""


def _with(coefficient: str) -> Reason:
    return lambda asked: asked.first_with(coefficient)


def _dark(asked: Asked) -> str | None:
    return None if asked.scene.lights else "the scene has no light"


def _flat(asked: Asked) -> str | None:
    return None if asked.depth > 1 else "max_depth = 1: camera rays only"


def _no_ambient(asked: Asked) -> str | None:
    ambient = asked.scene.ambient
    if "scene.ambient" in asked.free:
        return None
    return "ambient = 0" if not is_traced(ambient) and not np.any(np.asarray(ambient) > 0) else None


def _caster(asked: Asked) -> str | None:
    objects = asked.scene.objects
    if len(objects) == 1 and objects[0].FLAT:
        return None
    others = " and others" if len(objects) > 1 else ""
    return f"object {objects[0].name!r}{others} can block a light" if objects else None


def _no_shadows(asked: Asked) -> str | None:
    return 'shadows = "off"' if asked.scene.shadows == "off" else None


def _not_tinted(asked: Asked) -> str | None:
    return None if asked.scene.shadows == "tinted" else f'shadows = "{asked.scene.shadows}"'


def _denser(asked: Asked) -> str | None:
    for thing in asked.users("k_t"):
        index, name = asked.scene.materials[thing.material].refractive_index, f"{thing.material}.refractive_index"
        if is_traced(index) or name in asked.free:
            return f"object {thing.name!r}: {name} may be anything"
        if float(index) > 1:
            return f"object {thing.name!r}: {name} = {float(index):g}"
    return None


def _second_glass(asked: Asked) -> str | None:
    glass = asked.users("k_t")
    if len(glass) < 2 or not any(thing.solid for thing in glass):
        return None
    return f"objects {glass[0].name!r} and {glass[1].name!r} are both transparent"


def _touching(asked: Asked) -> str | None:
    sheets = asked.sheets
    return f"objects {sheets[0][0][0]!r} and {sheets[0][1][0]!r} share a surface" if sheets else None


def _textured(asked: Asked) -> str | None:
    for thing in asked.scene.objects:
        for coefficient, texture in asked.scene.materials[thing.material].textures:
            if asked.reasons.get((thing.material, coefficient)):
                return f"object {thing.name!r}: {coefficient}_texture = {texture!r}"
    return None


def _faded(asked: Asked) -> str | None:
    for number, light in enumerate(asked.scene.lights, 1):
        if light.fades:
            return f"light {number} has an attenuation"
    return None


def _gradient(asked: Asked) -> str | None:
    return "background = { gradient = ... }" if asked.scene.background.varies else None


def _truncated(asked: Asked) -> str | None:
    cutoff = asked.scene.cutoff
    if is_traced(cutoff):
        return "cutoff is traced and may be anything"
    return f"cutoff = {float(cutoff):.4g}" if float(cutoff) > 0 else None


LIT = (("diffuse", "highlight"), "no light is looked at")
BENT = (("refraction",), "no refraction")

EFFECTS: tuple[Effect, ...] = (
    Effect("ambient", _with("k_a"), "no object has k_a > 0", forbidden=_no_ambient),
    Effect("diffuse", _with("k_d"), "no object has k_d > 0", forbidden=_dark),
    Effect("highlight", _with("k_h"), "no object has k_h > 0 with a highlight", forbidden=_dark),
    Effect("shadows", _caster, "no object can stand between a point and a light", LIT, _no_shadows),
    Effect("tinted_shadows", _with("k_t"), "no object has k_t > 0", (("shadows",), "no shadow ray is cast"),
           _not_tinted),
    Effect("reflection", _with("k_s"), "no object has k_s > 0", forbidden=_flat),
    Effect("refraction", _with("k_t"), "no object has k_t > 0", forbidden=_flat),
    Effect("total_internal_reflection", _denser, "every transparent object has index 1", BENT),
    Effect("nested_media", _second_glass, "fewer than two transparent solids", BENT),
    Effect("shared_surfaces", _touching, "no transparent object shares a surface with another", BENT),
    Effect("textures", _textured, "no coefficient in use has a texture"),
    Effect("attenuation", _faded, "no point light has an attenuation", LIT,
           without=lambda s: changed(s, lights=tuple(light.without_fading() for light in s.lights))),
    Effect("background_gradient", _gradient, "the background is one colour",
           without=lambda s: changed(s, background=s.background.plain())),
    Effect("footprint", lambda asked: f"footprint = {asked.trees}" if asked.trees else None, "footprint = 0"),
    Effect("cutoff", _truncated, "cutoff = 0", (("reflection", "refraction"), "no ray is reflected or refracted")),
)  # fmt: skip
"""The effects that the package has."""

EFFECT_NAMES = tuple(effect.name for effect in EFFECTS)

_added: list[Effect] = []


def effect_rows() -> tuple[Effect, ...]:
    """All effects: those of the package and those that were added."""
    return (*EFFECTS, *_added)


@contextmanager
def including_effect(row: Effect) -> Iterator[Effect]:
    """The table with one row more, for the length of a `with` block."""
    _added.append(row)
    try:
        yield row
    finally:
        _added.remove(row)


@dataclass(frozen=True)
class Effects:
    """Which effects are on; hashable, so that it selects the compiled program. `effects.shadows` asks for one of
    them.
    """

    on: frozenset[str]

    def __contains__(self, name: str) -> bool:
        return name in self.on

    def __getattr__(self, name: str) -> bool:
        if name.startswith("_") or name not in {row.name for row in effect_rows()}:
            raise AttributeError(f"there is no effect {name!r}")
        return name in self.on

    def switched(self, **effects: bool) -> "Effects":
        """The same with some effects on or off."""
        chosen = {name for name, on in effects.items() if on}
        return Effects(frozenset((self.on - effects.keys()) | chosen))

    def without(self, name: str) -> "Effects":
        """The same without one effect, and without those that cannot do without it."""
        on = self.on - {name}
        for row in effect_rows():
            if row.name in on and row.needs[0] and not on.intersection(row.needs[0]):
                on = on - {row.name}
        return Effects(on)

    @property
    def branching(self) -> bool:
        """Does any ray have children?"""
        return self.reflection or self.refraction

    @property
    def lighting(self) -> bool:
        """Does any light have to be looked at?"""
        return self.diffuse or self.highlight


@dataclass(frozen=True)
class Decision:
    """One effect, on or off, and the reason in words."""

    name: str
    on: bool
    why: str


def decide_effects(
    scene: Scene, free: Collection[str] = (), max_depth: int | None = None, footprint: int | None = None
) -> tuple[Decision, ...]:
    """Decide every effect for a scene and the free coefficients of a fit, in the order of the table.

    `max_depth` and `footprint` replace the scene's.
    """
    depth = scene.max_depth if max_depth is None else max_depth
    asked = Asked(scene, frozenset(free), depth, scene.footprint if footprint is None else footprint)
    decided: list[Decision] = []
    on: set[str] = set()
    for row in effect_rows():
        needed, missing = row.needs
        why_not = row.forbidden(asked) or (missing if needed and not on.intersection(needed) else None)
        reason = None if why_not else row.called_for(asked)
        decided.append(Decision(row.name, reason is not None, reason or why_not or row.otherwise))
        if reason is not None:
            on.add(row.name)
    return tuple(decided)


def as_effects(decisions: tuple[Decision, ...]) -> Effects:
    return Effects(frozenset(decision.name for decision in decisions if decision.on))
