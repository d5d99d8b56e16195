"""What a scene does not call for is not in its compiled program, and leaving it out changes no pixel.

Every effect has a pair of scenes that look the same: one that does not call for it, and one that does without a trace
in the picture (a coefficient that is free but zero, a texture that is white, a light that sees every point).
"""

import dataclasses
import functools
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.rendering._passes import _render_passes
from diffwhitted.tree import EFFECT_NAMES, make_plan, tables_of

SKY = (0.2, 0.4, 0.8)
EVEN = np.eye(9)[0][:, None] * SKY * np.sqrt(4 * np.pi)
"""The same as harmonics."""
WHITE = ((1, 1, 1), (1, 1, 1))
BEHIND = [[0, 0, 9], [1, 0, 9], [0, 1, 9]]


@dataclass(frozen=True)
class Variant:
    """A scene by what differs from the usual one, and the coefficients that are free."""

    ball: tuple = (("k_d", 0.5), ("k_h", 0.0), ("phong_exponent", 10.0))
    floor: tuple = (("k_d", 0.3), ("k_h", 0.0))
    attenuation: tuple | None = None
    gradient: bool = False
    surrounded: bool = False
    shadows: str = "off"
    free: tuple = ()
    radius: float = 1.0
    footprint: int = 0
    cutoff: float = 0.0
    twin: bool = False
    cone: float | None = None
    sky: bool = False
    lamp_ball: bool = False
    fade: tuple | None = None
    lens: tuple = ()
    """Keys of the camera that blur."""
    speed: float | None = None
    """Of the ball, straight ahead, m/s."""
    walled: bool = False
    """The ground has an end."""
    radiosity: bool = False
    unseen: str | None = None
    """The shading of a mesh behind the camera."""
    scene: dw.Scene = field(init=False, compare=False)

    def __post_init__(self):
        here = (0, 0.5, 5)  # where the camera is: no shadow shows
        light = dw.PointLight(here, 0.8, attenuation=self.attenuation)
        if self.lamp_ball:
            light = dw.SphereLight(here, 1e-4, 0.8)
        if self.cone:
            light = dw.SpotLight(here, 0.8, look_at=(0, 0, 0), cone_deg=self.cone)
        object.__setattr__(
            self,
            "scene",
            dw.Scene(
                objects=[
                    dw.Sphere("ball", (0, 0, 0), self.radius, "paint").moving(self.speed and (self.speed, 0, 0)),
                    dw.Polygon("ground", GROUND, "plain")
                    if self.walled
                    else dw.Plane("ground", (0, 1, 0), -1, "plain"),
                    *[dw.Sphere("twin", (0, 0, 0), self.radius, "paint")] * self.twin,
                    *[dw.Mesh("unseen", BEHIND, [[0, 1, 2]], "plain", shading=self.unseen)] * bool(self.unseen),
                ],
                materials={"paint": dw.Material(**dict(self.ball)), "plain": dw.Material(**dict(self.floor))},
                lights=[light],
                textures={"white": dw.Checker(WHITE), "even": dw.Waves(WHITE)}
                if {"k_d_texture", "height_texture"} & {*dict(self.floor), *dict(self.ball)}
                else {},
                background=dw.GradientBackground(SKY, SKY)
                if self.gradient
                else dw.HarmonicBackground(EVEN)
                if self.surrounded
                else dw.ConstantBackground(SKY),
                cameras={"main": dw.Camera((0, 0.5, 5), (0, 0, 0), 40, 8, 6, **dict(self.lens))},
                shadows=self.shadows,
                ambient=dw.Hemisphere((1, 1, 1), (1, 1, 1)) if self.sky else 1.0,
                distance_fade=self.fade,
                radiosity={"patches": 20} if self.radiosity else None,
                max_depth=3,
                footprint=self.footprint,
                cutoff=self.cutoff,
            ),
        )

    @property
    def camera(self):
        return self.scene.cameras["main"]

    @property
    def plan(self):
        return make_plan(self.scene, self.camera, free=self.free)


GROUND = [(-9, -1, -9), (-9, -1, 9), (9, -1, 9), (9, -1, -9)]
BARE = Variant()
UNLIT = Variant(ball=(("k_a", 0.5), ("k_h", 0.0)), floor=(("k_a", 0.3), ("k_h", 0.0)))
ROOM = Variant(
    ball=(("k_a", 0.5), ("k_h", 0.0)), floor=(("k_a", 0.5), ("k_h", 0.0)), radius=100.0
)  # one colour in every direction
MIRRORING = Variant(free=("paint.k_s",))
GLASSY = Variant(free=("paint.k_t",))
SHINY = Variant(free=("paint.k_h",))
UNSEEN = Variant(radius=1e-6, free=("paint.k_s",))  # the ball is between two pixels, whatever it is made of
SHADED = Variant(free=("paint.k_t",), shadows="opaque")
SMOOTH = Variant(unseen="phong")
WALLED = Variant(ball=(("k_h", 0.0),), floor=(("k_h", 0.0),), walled=True)

PAIRS = {
    "ambient": (BARE, Variant(free=("paint.k_a",))),
    "hemisphere": (UNLIT, dataclasses.replace(UNLIT, sky=True)),
    "diffuse": (UNLIT, dataclasses.replace(UNLIT, free=("paint.k_d",))),
    "highlight": (BARE, Variant(free=("paint.k_h",))),
    "environment": (
        dataclasses.replace(UNLIT, surrounded=True),
        dataclasses.replace(UNLIT, surrounded=True, free=("paint.k_d",)),
    ),
    "environment_highlight": (
        dataclasses.replace(UNLIT, surrounded=True),
        dataclasses.replace(UNLIT, surrounded=True, free=("paint.k_h",)),
    ),
    "radiosity": (WALLED, dataclasses.replace(WALLED, radiosity=True, free=("paint.k_d",))),
    "emission": (UNSEEN, dataclasses.replace(UNSEEN, ball=(*BARE.ball, ("emission", 1.0)))),
    "polished": (UNSEEN, Variant(ball=(("class", "polished"), ("k_d", 0.5)), radius=1e-6)),
    "fresnel_highlight": (
        SHINY,
        dataclasses.replace(SHINY, ball=(*BARE.ball, ("fresnel", "exact"), ("fresnel_highlight", True))),
    ),
    "shadows": (BARE, Variant(shadows="opaque")),
    "tinted_shadows": (SHADED, dataclasses.replace(SHADED, shadows="tinted")),
    "soft_shadows": (Variant(shadows="opaque"), Variant(shadows="opaque", lamp_ball=True)),
    "reflection": (BARE, MIRRORING),
    "refraction": (BARE, GLASSY),
    "total_internal_reflection": (GLASSY, Variant(free=("paint.k_t", "paint.refractive_index"))),
    "fresnel_exact": (MIRRORING, dataclasses.replace(MIRRORING, ball=(*BARE.ball, ("fresnel", "exact")))),
    "fresnel_schlick": (MIRRORING, dataclasses.replace(MIRRORING, ball=(*BARE.ball, ("fresnel", "schlick")))),
    "fresnel_metal": (UNSEEN, dataclasses.replace(UNSEEN, ball=(("class", "metal"), ("k_s", 0.5), ("k_h", 0.0)))),
    "dispersion": (GLASSY, dataclasses.replace(GLASSY, ball=(*BARE.ball, ("abbe_number", 40.0)))),
    "gloss": (MIRRORING, dataclasses.replace(MIRRORING, ball=(*BARE.ball, ("roughness", 0.1)))),
    "wrinkles": (BARE, Variant(ball=(*BARE.ball, ("height_texture", "even"), ("height_scale", 0.1)))),
    "lens": (BARE, Variant(lens=(("aperture", 1e-7), ("focus", 5.0), ("blur_samples", 1)))),
    "motion": (BARE, Variant(lens=(("shutter", 1e-7), ("blur_samples", 1)), speed=0.1)),
    "absorption": (GLASSY, Variant(free=("paint.k_t", "paint.extinction"))),
    "nested_media": (GLASSY, Variant(free=("paint.k_t", "plain.k_t"))),
    "shared_surfaces": (GLASSY, dataclasses.replace(GLASSY, twin=True)),
    "gouraud": (SMOOTH, Variant(unseen="gouraud")),
    "fast_phong": (SMOOTH, Variant(unseen="fast_phong")),
    "textures": (BARE, Variant(floor=(*BARE.floor, ("k_d_texture", "white")))),
    "attenuation": (BARE, Variant(attenuation=(1.0, 0.0, 0.0))),
    "light_borders": (BARE, Variant(cone=80.0)),
    "distance_fade": (BARE, Variant(fade=(1.0, 0.0))),
    "background_gradient": (BARE, Variant(gradient=True)),
    "footprint": (ROOM, dataclasses.replace(ROOM, footprint=1)),
    "cutoff": (MIRRORING, dataclasses.replace(MIRRORING, cutoff=0.5)),
}

OPERATIONS = {"highlight": ("exponential", "log-plus-one"), "textures": ("floor",)}
"""What only this effect needs."""


@functools.cache
def compiled(variant, plan=None):
    plan = plan or variant.plan
    return _render_passes.lower(tables_of(variant.scene, plan), variant.camera, plan.program, 1).compile()


def flops(program):
    return program.compiled.cost_analysis()["flops"]


def operations(program, name):
    return program.compiled.as_text().count(f" {name}(")


def picture(variant):
    plan = variant.plan
    image, needed = compiled(variant)(tables_of(variant.scene, plan), variant.camera, plan.program, 1)
    assert needed <= variant.plan.capacity
    return np.asarray(image)


def test_every_effect_is_here():
    assert tuple(PAIRS) == EFFECT_NAMES


@pytest.mark.parametrize("effect", PAIRS)
def test_what_is_off_costs_nothing_and_shows_nothing(effect):
    without, neutral = PAIRS[effect]
    off, on = without.plan.effects, neutral.plan.effects
    assert not getattr(off, effect) and getattr(on, effect)
    assert flops(compiled(without)) < flops(compiled(neutral))
    for name in OPERATIONS.get(effect, ()):
        assert operations(compiled(without), name) == 0 < operations(compiled(neutral), name)
    np.testing.assert_allclose(picture(without), picture(neutral), atol=1e-6)


def test_a_bare_scene_needs_no_power_in_any_form():
    assert [operations(compiled(BARE), name) for name in ("power", "exponential", "log-plus-one", "log")] == [0] * 4


@pytest.mark.parametrize("effect", ["shadows", "textures"])
def test_a_scene_that_does_not_call_for_it_costs_the_same_as_with_it_forced_off(effect):
    without, neutral = PAIRS[effect]
    forced = dataclasses.replace(neutral.plan, effects=neutral.plan.effects.switched(**{effect: False}))
    assert flops(compiled(neutral, forced)) == flops(compiled(without))


@pytest.mark.parametrize("effect", PAIRS)
def test_forcing_off_what_is_off_selects_the_same_program(effect):
    """The plan is the key of the compiled program: an equal plan is the same program."""
    plan = PAIRS[effect][0].plan
    forced = dataclasses.replace(plan, effects=plan.effects.switched(**{effect: False}))
    assert forced == plan and hash(forced) == hash(plan)


def test_what_no_object_is_made_of_calls_for_nothing():
    scene = BARE.scene
    idle = dw.Scene(
        objects=scene.objects,
        materials=dict(scene.materials) | {"idle": dw.Material(k_a=1, k_d=1, k_h=1, k_s=1, k_t=1, refractive_index=2)},
        textures={"idle": dw.Checker(((0, 0, 0), (1, 1, 1)))},
        lights=scene.lights,
        background=scene.background,
        shadows="off",
        max_depth=3,
    )
    assert make_plan(idle, BARE.camera).effects == BARE.plan.effects


# Reasons


def reasons(scene, **how):
    return {d.name: (d.on, d.why) for d in dw.decide_effects(scene, **how)}


def everything():
    return dw.Scene(
        objects=[
            dw.Plane("ground", (0, 1, 0), -1, "tiles"),
            dw.Sphere("ball", (0, 0, 0), 1, "glass"),
            dw.Sphere("bead", (0, 0, 0), 0.4, "glass"),
            dw.Sphere("skin", (0, 0, 0), 0.4, "tiles"),
            *(dw.Mesh(shading, BEHIND, [[0, 1, 2]], "tiles", shading=shading) for shading in ("gouraud", "fast_phong")),
        ],
        materials={
            "glass": dw.Material(k_h=0.25, k_s=0.2, k_t=(0.0, 0.7, 0.8), refractive_index=1.5),
            "tiles": dw.Material(k_a=0.1, k_d=0.6, k_h=0, k_d_texture="checks"),
        },
        lights=[
            dw.DirectionalLight((0, 1, 0), 1),
            dw.PointLight((0, 5, 0), 1, attenuation=(1, 0, 0.1)),
            dw.SpotLight((0, 5, 0), 1, direction=(0, -1, 0), cone_deg=30),
            dw.SphereLight((0, 5, 0), 0.1, 1),
        ],
        ambient=dw.Hemisphere((1, 1, 1), (0, 0, 0)),
        distance_fade=(1.0, -0.25),
        textures={"checks": dw.Checker(((0, 0, 0), (1, 1, 1)))},
        background=dw.GradientBackground(SKY, SKY),
        shadows="tinted",
        footprint=1,
        cutoff=0.01,
    )


OF_OTHERS = (
    "environment", "environment_highlight", "polished", "fresnel_highlight", "fresnel_exact", "fresnel_schlick",
    "fresnel_metal", "absorption", "dispersion", "gloss", "wrinkles", "lens", "motion", "radiosity", "emission",
)  # fmt: skip
"""What scenes of other backgrounds and classes of materials call for."""


def test_reasons_name_the_object_and_the_coefficient():
    """The first object that calls for it, the coefficient by its full name, and its value."""
    given = reasons(everything())
    assert all(on for name, (on, _) in given.items() if name not in OF_OTHERS)
    assert given["environment"] == (False, "the background lights no surface")
    assert given["ambient"][1] == "object 'ground': tiles.k_a = 0.1"
    assert given["diffuse"][1] == "object 'ground': tiles.k_d = 0.6"
    assert given["highlight"][1] == "object 'ball': glass.k_h = 0.25"
    assert given["reflection"][1] == "object 'ball': glass.k_s = 0.2"
    assert given["refraction"][1] == "object 'ball': glass.k_t = [0. , 0.7, 0.8]"
    assert given["tinted_shadows"][1] == "object 'ball': glass.k_t = [0. , 0.7, 0.8]"
    assert given["total_internal_reflection"][1] == "object 'ball': glass.refractive_index = 1.5"
    assert given["nested_media"][1] == "objects 'ball' and 'bead' are both transparent"
    assert given["shared_surfaces"][1] == "objects 'bead' and 'skin' share a surface"
    assert given["gouraud"][1] == "object 'gouraud': shading = \"gouraud\""
    assert given["textures"][1] == "object 'ground': k_d_texture = 'checks'"
    assert given["attenuation"][1] == "light 2 has an attenuation"
    assert given["light_borders"][1] == "light 3 has a cone or flaps"
    assert given["soft_shadows"][1] == "light 4 is a ball that one ray looks at"
    assert given["hemisphere"][1] == "ambient = { sky = ..., ground = ... }"
    assert given["distance_fade"][1] == "distance_fade = [1.0, -0.25]"
    assert "gradient" in given["background_gradient"][1] and "'ground'" in given["shadows"][1]


def test_reasons_for_what_is_off():
    given = reasons(BARE.scene)
    assert [name for name, (on, _) in given.items() if on] == ["diffuse"]
    assert given["reflection"][1] == "no object has k_s > 0" and given["shadows"][1] == 'shadows = "off"'
    assert (
        given["total_internal_reflection"][1] == "no refraction"
        and given["attenuation"][1] == "no point light has an attenuation"
    )
    shallow = reasons(everything(), max_depth=1)
    assert all(shallow[name] == (False, "max_depth = 1: camera rays only") for name in ("reflection", "refraction"))
    dark = reasons(
        dw.Scene(
            objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint")],
            materials={"paint": dw.Material(k_d=1, k_h=1)},
            ambient=0,
        )
    )
    assert [dark[name] for name in ("diffuse", "highlight")] == [(False, "the scene has no light")] * 2
    assert not any(on for on, _ in dark.values())


@pytest.mark.parametrize(
    "coefficient, effect", [("k_a", "ambient"), ("k_h", "highlight"), ("k_s", "reflection"), ("k_t", "refraction")]
)
def test_a_coefficient_that_is_free_or_traced_keeps_its_effect_at_zero(coefficient, effect):
    name = f"paint.{coefficient}"
    free = reasons(BARE.scene, free=(name,))
    assert free[effect] == (True, f"object 'ball': {name} is free in the fit") and not reasons(BARE.scene)[effect][0]
    seen = []

    @jax.jit
    def traced(value):
        seen.append(reasons(dw.replace_coefficient(BARE.scene, name, value))[effect])
        return value

    traced(jnp.zeros(()))
    assert seen == [(True, f"object 'ball': {name} is traced and may be anything")]


def test_a_highlight_that_follows_a_free_k_s():
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint")],
        materials={"paint": dw.Material()},
        lights=[dw.PointLight((0, 9, 0), 1)],
    )
    assert reasons(scene, free=("paint.k_s",))["highlight"] == (True, "object 'ball': paint.k_s is free and gives k_h")
    assert not reasons(scene, free=("paint.k_d",))["highlight"][0]


def test_a_whole_group_of_effects_is_off_together():
    """Without children no light but the local one, without lighting no shadows."""
    bare = BARE.plan
    assert not bare.effects.branching and bare.capacity == 0 and bare.effects.lighting
    unlit = Variant(ball=UNLIT.ball, floor=UNLIT.floor, shadows="tinted").plan.effects
    assert not (unlit.lighting or unlit.shadows or unlit.tinted_shadows)
