"""Pictures of shapes: POV-Ray's own of the same scenes, a furnace, and derivatives against differences of pictures."""

import functools
import shutil

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from shape_samples import CORNERS, STAIRS

import diffwhitted as dw
from benchmarks import _povray
from diffwhitted.records import changed
from references.supersampled import area_true, cosine, relative

EGG = (1, 2, 0.8, 0.3, -0.2, 0.1, 0, 0, 0, -0.2)
SOLIDS = [
    dw.Torus("ring", (-1.3, 0.1, 0.3), (0.2, 1, 0.3), 0.6, 0.25, "glass"),
    dw.Box("die", (-0.4, -0.4, -0.4), (0.4, 0.3, 0.4), "amber").placed(
        rotate_deg=(20, 30, 10), translate=(0.2, 0, 0.8)
    ),
    dw.Sphere("seed", (0.2, 0, 0.8), 0.2, "red"),
    dw.Cone("cup", (1.4, -0.7, 0), (1.3, 0.5, 0.1), 0.6, 0.2, "glass"),
    dw.Quadric("egg", EGG, "amber").placed(translate=(0, 0.9, -0.6)),
]
"""Glass, with a ball of something else in the middle of the box."""
SHEETS = [
    dw.Cylinder("tube", (-1.9, 0.2, 0), (-0.9, -0.2, 0.6), 0.4, "red", capped=False),
    dw.Cylinder("rod", (-0.6, -0.9, -0.9), (-0.5, 1.3, -0.8), 0.25, "steel"),
    dw.Quadric("saddle", (1, 0, -1, 0, 0, 0, 0, -1, 0, 0), "red", (-0.5, -0.3, -0.5), (0.5, 0.3, 0.5)).placed(
        rotate_deg=(20, 40, 10), translate=(0.4, 0.2, 0.4)),
    dw.Disc("mirror", (1.6, 0.6, -1), (-0.5, 0, 1), 0.9, "steel"),
    dw.Polyhedron("stairs", CORNERS, STAIRS, "glass").placed(
        scale=(0.5, 0.4, 0.6), rotate_deg=(0, -50, 0), translate=(0.9, -0.8, 0.3)),
    dw.Cone("bowl", (-0.2, -0.8, 1.1), (-0.25, -0.4, 1.15), 0.2, 0.5, "steel", capped=False),
]  # fmt: skip
MATERIALS = {
    "glass": dw.Material(k_t=0.9, k_s=0.06, k_h=0.3, refractive_index=1.5, phong_exponent=80),
    "amber": dw.Material(k_d=0.05, k_t=[0.9, 0.7, 0.4], k_s=0.05, k_h=0.2, refractive_index=1.3),
    "red": dw.Material(k_a=[0.1, 0.02, 0.02], k_d=[0.7, 0.2, 0.1], k_h=0.2),
    "steel": dw.Material(k_a=0.05, k_d=0.2, k_s=0.5, k_h=0.3),
    "floor": dw.Material(k_a=0.2, k_d=0.6, k_d_texture="tiles", highlight="off"),
}


def scene_of(objects, camera=None, **settings):
    stated = dict(
        objects=[*objects, dw.Plane("floor", (0, 1, 0), -1, "floor")],
        materials=MATERIALS,
        textures={"tiles": dw.Checker([(0.9, 0.4, 0.3), (1, 1, 1)], 0.4, "xz")},
        lights=[dw.PointLight((3, 6, 5), (0.8, 0.8, 0.8)), dw.DirectionalLight((-1, 1, 0.5), 0.2)],
        background=dw.GradientBackground((0.2, 0.2, 0.3), (0.5, 0.7, 0.9)),
        cameras={"main": camera or dw.Camera((0.2, 1.6, 5.5), (0, 0, 0), 36, 96, 72)},
        max_depth=6,
        shadows="tinted",
    )
    return dw.Scene(**{**stated, **settings})


@pytest.mark.skipif(shutil.which("povray") is None, reason=_povray.MISSING)
@pytest.mark.parametrize("objects", [SOLIDS, SHEETS], ids=["solids", "sheets"])
def test_povray_renders_the_same_picture(objects, tmp_path):
    """Mirrors, glass with something in it, tinted shadows. A few pixels lie on edges, where rounding decides."""
    scene = scene_of(objects)
    assert dw.save_scene(scene, tmp_path / "scene.pov") == ()
    theirs = _povray.trace(tmp_path / "scene.pov", 96, 72).pixels
    apart = np.abs(np.asarray(dw.render(scene, scene.cameras["main"])) - theirs).max(axis=-1)
    assert np.median(apart) < 3e-4 and np.quantile(apart, 0.98) < 6e-4
    assert (apart > 0.01).mean() < 6e-3


@pytest.mark.parametrize("inside", [False, True])
def test_glass_that_takes_nothing_is_not_seen_in_a_furnace(inside):
    """All light is let through, wherever it is bent and reflected totally, and comes from everywhere alike; also with
    the camera in the box. What is left out has more than 24 levels.
    """
    clear = dw.Material(k_t=1.0, refractive_index=1.2, highlight="off")
    ball = dw.Sphere("ball", (1.35, -0.1, 0.05), 0.2, "clear")
    things = [changed(thing, material="clear") for thing in (*SOLIDS, ball)]
    stairs = dw.Polyhedron("stairs", CORNERS, STAIRS, "clear").placed(scale=0.5, translate=(-0.6, -0.9, 1.2))
    eye = (0.1, 0.05, 0.75) if inside else (0.2, 1.6, 5.5)
    camera = dw.Camera(eye, (-0.3, 0.1, -2) if inside else (0, 0, 0), 80 if inside else 36, 32, 24)
    scene = dw.Scene(
        objects=[*things, stairs],
        materials={"clear": clear},
        background=dw.ConstantBackground((1, 1, 1)),
        cameras={"main": camera},
        max_depth=24,
    )
    picture = np.asarray(dw.render(scene, camera))
    assert picture.max() == pytest.approx(1, abs=1e-5)
    assert (picture[..., 0] > 1 - 1e-5).mean() > 0.995


NUMBERS = [
    "ring.major_radius", "ring.minor_radius", "ring.axis.x", "ring.centre.z", "die.rotate_deg.y", "die.translate.x",
    "die.maximum.y", "cup.top_radius", "cup.base.x", "egg.coefficients.xx", "egg.coefficients.xy", "egg.translate.z",
]  # fmt: skip


@functools.cache
def matt():
    """The solids without glass, close by, and the picture with its derivative, compiled once."""
    things = [changed(thing, material="red") for thing in SOLIDS if thing.name != "seed"]
    camera = dw.Camera((0.1, 1.2, 4.2), (0, 0.2, 0), 40, 24, 18)
    scene = scene_of(things, camera, precision="float64", max_depth=1)
    plan = dw.plan(scene, camera, max_depth=1)

    def picture(scene):
        return dw.render(scene, camera, plan=plan)

    return scene, eqx.filter_jit(lambda scene, along: jax.jvp(picture, (scene,), (along,)))


@pytest.mark.parametrize("number", NUMBERS)
def test_the_derivative_of_a_picture_is_that_of_differences(number):
    """Where no edge passes a pixel, of an object or of a shadow: pixels whose second difference is as small as its
    step.
    """
    scene, program = matt()
    name = f"object.{number}"
    value = float(dw.parameter_value(scene, name))

    def at(number):
        return dw.replace_parameter(scene, name, number)

    along = jax.jvp(at, (jnp.float64(value),), (jnp.float64(1),))[1]
    image, slope = program(scene, along)
    step = 1e-4 if "rotate" not in name else 1e-3
    below, above = (np.asarray(program(at(value + d), along)[0]) for d in (-step, step))
    still = (abs(above + below - 2 * np.asarray(image)) < 300 * step * step).all(axis=-1)
    assert still.mean() > 0.8 and np.isfinite(slope).all()
    central = ((above - below) / (2 * step))[still]
    assert abs(central).max() > 1e-3
    np.testing.assert_allclose(np.asarray(slope)[still], central, rtol=2e-3, atol=2e-5)


def test_the_rim_of_a_disc_moves_in_filtered_pictures():
    """A disc and its shadow: picture and derivative in its radius against a difference of 32 x 32 points a pixel."""
    disc = dw.Disc("thing", (0, 0.1, 0), (0.3, 1, 0.5), 0.9, "red")
    view = dw.Camera((0.2, 1.6, 5.5), (0, 0, 0), 28, 40, 30)
    scene = scene_of([disc], view, max_depth=1, lights=[dw.PointLight((1, 6, 2), 0.8)])
    camera = scene.cameras["main"]
    plan = dw.plan(scene, camera, footprint=1, max_depth=1)
    plan = plan.with_capacity(2 * plan.capacity)

    def picture(radius):
        return dw.render(dw.replace_parameter(scene, "object.thing.radius", radius), camera, plan=plan)

    image, slope = jax.jit(lambda r: jax.jvp(picture, (r,), (jnp.ones_like(r),)))(jnp.float32(0.9))
    step = 0.01
    below, above = (
        area_true(dw.replace_parameter(scene, "object.thing.radius", 0.9 + d), camera, 32) for d in (-step, step)
    )
    central = (above - below) / (2 * step)
    assert np.sqrt(((np.asarray(image) - (above + below) / 2) ** 2).mean()) < 0.005
    assert cosine(np.asarray(slope, np.float64), central) > 0.98 and relative(np.asarray(slope), central) < 0.2
