"""Which effects a scene calls for, and why: one table of effects.

An effect that is off is not compiled. An effect is on when some coefficient calls for it: because its value
is not zero, because a fit leaves it free, or because it is traced by `jit`, `grad` or `vmap` and so may be
anything. A new effect is a row: what calls for it, what it cannot do without, and what it adds to the light of a
point or to the weights of its branches.
"""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Array, Float, Int

from ..illumination import SurfacePoint, fresnel_highlight, lit_above_horizon, polished, polished_towards  # fmt: skip
from ..numerics._vector import Vec3
from ..records import changed
from ..scene import AbstractCamera, Scene, Tables
from ._asked import Asked
from ._fresnel import Passed, dielectric, dielectric_extremes, metal, metal_extremes
from ._light_effects import (
    by_one_ray,
    distance_faded,
    evenly_lit,
    faded_by_distance,
    hardened,
    hemispherical,
    most_left,
)  # fmt: skip
from ._material_effects import by_phong, most_of_metal, most_when_polished
from ._patches import brightest_of_patches, sent_back_of_patches, sent_out, sent_out_at_most
from ._reasons import (
    Reason,
    absorbing,
    at_rest,
    between_surfaces,
    caster,
    coated,
    dark,
    denser,
    dispersing,
    flat,
    gradient,
    interpolated,
    moving,
    no_ambient,
    no_light_around,
    no_shadows,
    not_between_surfaces,
    not_tinted,
    one_band,
    rough,
    second_glass,
    shiny,
    textured,
    touching,
    truncated,
    weighed_highlight,
    with_coefficient,
    with_fresnel,
    with_lens,
    with_light,
    wrinkled,
)  # fmt: skip
from ._surrounded import brightest_of, sent_back_diffusely, sent_back_in_highlight

Coefficients = dict[str, Any]


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
    dims: Callable[[Tables, Float[Array, "n"]], Float[Array, "n"]] | None = None
    """What is left of all light along a ray of so many metres between two surfaces, or to the camera."""
    dims_to: Callable[[Scene], float] | None = None
    """The most that `dims` is at any distance; None: no finite number is known."""
    brightest: Callable[[Scene, str], np.ndarray] | None = None
    """The most light that it adds at a point of a material (by name), (3,); None: no finite amount is known."""
    extremes: tuple[str, Callable[[np.ndarray, np.ndarray], tuple[Passed, ...]]] | None = None
    """Of what it weighs: the model of materials that it is about, and the weights, from their k_s and k_t, of which
    those of each angle are a mean; None: no bound is known."""
    at_points: Callable[[SurfacePoint], Coefficients] | None = None
    """The coefficients that stand in place of those of a point."""
    at_lights: Callable[[SurfacePoint, Vec3], Coefficients] | None = None
    """The same for one light, by the direction to it."""
    most: Callable[[Scene, str, dict[str, np.ndarray]], dict[str, np.ndarray]] = lambda scene, name, most: most
    """What it makes, at most, of the coefficients of a material, (3,) each."""
    models: tuple[str, ...] = ()
    """The choices of materials that it reads (see `CHOICES`)."""
    indices: bool = False
    """It looks at the refractive indices on both sides."""


LIT = (("diffuse", "highlight"), "no light is looked at")
BENT = (("refraction",), "no refraction")
SEEN = (
    ("hemisphere", "diffuse", "highlight", "environment", "environment_highlight", "reflection", "refraction"),
    "nothing hangs on normals",
)
SPLIT = (("reflection", "refraction"), "no ray is reflected or refracted")


EFFECTS: tuple[Effect, ...] = (
    Effect("ambient", with_coefficient("k_a"), "no object has k_a > 0", forbidden=no_ambient),
    Effect("hemisphere", hemispherical, "ambient light is alike from all sides", (("ambient",), "no ambient light"),
           without=evenly_lit),
    Effect("diffuse", with_coefficient("k_d"), "no object has k_d > 0", forbidden=dark),
    Effect("highlight", with_coefficient("k_h"), "no object has k_h > 0 with a highlight", forbidden=dark),
    Effect("environment", with_coefficient("k_d"), "no object has k_d > 0", forbidden=no_light_around,
           adds=sent_back_diffusely, brightest=brightest_of("k_d")),
    Effect("environment_highlight", shiny, "no object states a k_h > 0", forbidden=no_light_around,
           adds=sent_back_in_highlight, brightest=brightest_of("k_h")),
    Effect("radiosity", between_surfaces, "no object has k_d > 0", forbidden=not_between_surfaces,
           adds=sent_back_of_patches, brightest=brightest_of_patches, without=lambda s: changed(s, radiosity=None)),
    Effect("emission", with_coefficient("emission"), "no object has emission > 0", coefficients=("emission",),
           adds=sent_out, brightest=sent_out_at_most),
    Effect("polished", coated, "no object is polished",
           (("ambient", "diffuse", "environment", "radiosity"), "no light is looked at"),
           at_points=polished, at_lights=polished_towards, models=("polished",), indices=True, most=most_when_polished),
    Effect("fresnel_highlight", weighed_highlight, "no material has fresnel_highlight",
           (("highlight",), "no highlight is looked at"), at_lights=fresnel_highlight,
           models=("fresnel", "fresnel_highlight", "highlight"), indices=True,
           most=most_of_metal),
    Effect("shadows", caster, "no object can stand between a point and a light", LIT, no_shadows),
    Effect("tinted_shadows", with_coefficient("k_t"), "no object has k_t > 0", (("shadows",), "no shadow ray is cast"),
           not_tinted),
    Effect("soft_shadows", with_light(by_one_ray, "is a ball that one ray looks at"),
           "no light is a ball that one ray looks at", (("shadows",), "no shadow ray is cast"),
           without=hardened),
    Effect("reflection", with_coefficient("k_s"), "no object has k_s > 0", forbidden=flat),
    Effect("refraction", with_coefficient("k_t"), "no object has k_t > 0", forbidden=flat),
    Effect("total_internal_reflection", denser, "every transparent object has index 1", BENT),
    Effect("fresnel_exact", with_fresnel("exact"), 'no material has fresnel = "exact"', SPLIT, indices=True,
           models=("fresnel",), weighs=dielectric("exact"), extremes=("exact", dielectric_extremes)),
    Effect("fresnel_schlick", with_fresnel("schlick"), 'no material has fresnel = "schlick"', SPLIT, indices=True,
           models=("fresnel",), weighs=dielectric("schlick"), extremes=("schlick", dielectric_extremes)),
    Effect("fresnel_metal", with_fresnel("metal"), 'no metal has fresnel = "schlick"', SPLIT,
           models=("fresnel",), weighs=metal, extremes=("metal", metal_extremes)),
    Effect("dispersion", dispersing, "no index hangs on the wavelength", SPLIT, one_band),
    Effect("gloss", rough, "no surface that sends rays on is rough", SPLIT),
    Effect("wrinkles", wrinkled, "no material bends normals", SEEN, at_lights=lit_above_horizon),
    Effect("lens", with_lens, "no camera has aperture > 0"),
    Effect("motion", moving, "no camera has shutter > 0", forbidden=at_rest),
    Effect("absorption", absorbing, "no transparent object has extinction > 0", BENT),
    Effect("nested_media", second_glass, "fewer than two transparent solids", BENT),
    Effect("shared_surfaces", touching, "no transparent object shares a surface with another", BENT),
    Effect("gouraud", interpolated("gouraud"), "no object is shaded so", LIT, without=by_phong("gouraud")),
    Effect("fast_phong", interpolated("fast_phong"), "no object is shaded so", LIT, without=by_phong("fast_phong")),
    Effect("textures", textured, "no coefficient in use has a texture"),
    Effect("attenuation", with_light(lambda light: light.fades, "has an attenuation"),
           "no point light has an attenuation", LIT,
           without=lambda s: changed(s, lights=tuple(light.without_fading() for light in s.lights))),
    Effect("light_borders", with_light(lambda light: light.bordered, "has a cone or flaps"),
           "no light has a cone or flaps", LIT,
           without=lambda s: changed(s, lights=tuple(light.without_borders() for light in s.lights))),
    Effect("distance_fade", distance_faded, "no distance_fade", without=lambda s: changed(s, distance_fade=None),
           dims=faded_by_distance, dims_to=most_left),
    Effect("background_gradient", gradient, "the background is one colour",
           without=lambda s: changed(s, background=s.background.plain())),
    Effect("footprint", lambda asked: f"footprint = {asked.trees}" if asked.trees else None, "footprint = 0"),
    Effect("cutoff", truncated, "cutoff = 0", SPLIT),
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
    def indices(self) -> bool:
        """Are the refractive indices on both sides of a surface looked at?"""
        return self.refraction or any(row.indices for row in effect_rows() if row.name in self.on)

    def choices(self, highlights: Collection[str]) -> list[str]:
        """What a point has to know of the choices of its material (see `CHOICES`), with these highlights."""
        read = {name for row in effect_rows() if row.name in self.on for name in row.models}
        return sorted(read | ({"highlight"} if self.highlight and len(highlights) > 1 else set()))

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
    scene: Scene,
    free: Collection[str] = (),
    max_depth: int | None = None,
    footprint: int | None = None,
    camera: AbstractCamera | None = None,
) -> tuple[Decision, ...]:
    """Decide every effect for a scene and the free coefficients of a fit, in the order of the table.

    `max_depth` and `footprint` replace the scene's, `camera` its cameras.
    """
    depth = scene.max_depth if max_depth is None else max_depth
    cameras = tuple(scene.cameras.values()) if camera is None else (camera,)
    asked = Asked(scene, frozenset(free), depth, scene.footprint if footprint is None else footprint, cameras)
    asked.check_clear()
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
