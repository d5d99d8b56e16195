"""The cutoff by throughput, and the bound on what it and the depth limit leave out, against much deeper trees."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from references.scenes import nested_glass
from references.supersampled import EXAMPLE

DEEP = 16
WHOLE = 1e-12
"""A cutoff that nothing is below; it shares the program of the others."""
SKY = dw.ConstantBackground((0.2, 0.3, 0.5))
FLOOR = dw.Material(k_d=0.6, k_a=0.1, k_h=0.0)


def hall_of_mirrors():
    """Two mirrors that face each other, a ball between them."""
    objects = [
        dw.Plane("left", (1, 0, 0), -2, "mirror"),
        dw.Plane("right", (-1, 0, 0), -2, "mirror"),
        dw.Plane("floor", (0, 1, 0), -1, "floor"),
        dw.Sphere("ball", (0, 0, 0), 0.7, "ball"),
    ]
    materials = {
        "mirror": dw.Material(k_s=0.8, k_h=0.0),
        "floor": FLOOR,
        "ball": dw.Material(k_d=0.5, k_a=0.1, k_s=0.2),
    }
    return _scene(objects, materials)


def _scene(objects, materials):
    return dw.Scene(
        objects=objects,
        materials=materials,
        lights=[dw.PointLight((0, 5, 3), (1, 1, 1))],
        background=SKY,
        cameras={"main": dw.Camera((0.3, 0.5, 6), (0, 0, 0), 50, 48, 36)},
    )


def example(name):
    scene = dw.load_scene(EXAMPLE.parent / f"{name}.toml")
    return eqx.tree_at(lambda s: s.cameras, scene, {"main": scene.cameras["main"].resized(48, 36)})


SCENES = {
    "hall of mirrors": hall_of_mirrors,
    "nested glass": lambda: nested_glass(50, 48, 36),
    "glass between spheres": lambda: example("glass_between_spheres"),
    "three spheres": lambda: example("three_spheres"),
}


@functools.cache
def scene_of(name):
    scene = SCENES[name]()
    return scene, scene.cameras["main"]


@functools.cache
def bounded(name, depth, cutoff):
    return dw.render_with_bound(*scene_of(name), max_depth=depth, cutoff=cutoff)


@pytest.mark.parametrize(
    "name, depth, cutoff",
    [
        *((name, DEEP, cutoff) for name in SCENES for cutoff in (0.05, 0.3)),
        ("hall of mirrors", 1, WHOLE),
        ("nested glass", 3, WHOLE),
    ],
)
def test_the_bound_holds_against_a_much_deeper_tree(name, depth, cutoff):
    whole, part = bounded(name, DEEP, WHOLE), bounded(name, depth, cutoff)
    missing = whole.image - part.image
    assert missing.min() > -1e-5 and (missing <= part.left_out + 1e-5).all()
    assert part.rays < whole.rays and part.most == part.left_out.max()


def test_the_bound_is_not_vacuous():
    """Within a factor of 20 of the largest error on three of the four scenes. Where k_s + k_t = 1 the series does not
    converge.
    """
    ratios = {
        name: bounded(name, DEEP, 0.05).most
        / (bounded(name, DEEP, WHOLE).image - bounded(name, DEEP, 0.05).image).max()
        for name in SCENES
    }
    assert sum(ratio < 20 for ratio in ratios.values()) >= 3, ratios


def test_nothing_is_left_out_of_a_tree_that_ends_by_itself():
    scene = _scene([dw.Sphere("ball", (0, 0, 0), 1, "matt")], {"matt": dw.Material(k_d=0.5)})
    found = dw.render_with_bound(scene, scene.cameras["main"], cutoff=0.5)
    assert found.most == 0 and found.left_out.shape == found.image.shape


def test_a_bound_past_all_numbers_is_infinite_where_light_is_left_out():
    scene, camera = scene_of("hall of mirrors")
    found = dw.render_with_bound(
        dw.replace_coefficient(scene, "mirror.k_s", jnp.asarray((5.0, 0.0, 0.0))), camera, max_depth=3
    )
    assert not np.isnan(found.left_out).any() and found.most == np.inf and (found.left_out[..., 1:] < 1).all()


def test_a_cutoff_drops_most_rays_of_nested_glass():
    """Cutoff 1/512: few of the rays. Several branches of a pixel may be below it, so the largest error is up to twice
    as large.
    """
    whole, part = bounded("nested glass", DEEP, WHOLE), bounded("nested glass", DEEP, 1 / 512)
    missing = whole.image - part.image
    assert part.rays < 0.25 * whole.rays and missing.max() < 2 / 512 and np.sqrt((missing**2).mean()) < 0.5 / 512


def test_the_derivatives_of_what_is_kept_are_exact():
    """Of the picture with a cutoff, by forward mode, against its own central difference: the tree is the same at both
    ends.
    """
    scene, camera = scene_of("hall of mirrors")
    scene = scene.with_cutoff(0.05)
    plan = dw.plan(scene, camera, max_depth=8)

    def image(k_s):
        return dw.render(dw.replace_coefficient(scene, "mirror.k_s", k_s), camera, plan=plan)

    slope = jax.jit(lambda k: jax.jvp(image, (k,), (jnp.ones_like(k),))[1])(jnp.full(3, 0.8, jnp.float32))
    ends = [np.asarray(image(jnp.full(3, 0.8 + step, jnp.float32)), np.float64) for step in (-1e-3, 1e-3)]
    np.testing.assert_allclose(slope, (ends[1] - ends[0]) / 2e-3, atol=2e-3)
    assert np.isfinite(slope).all() and abs(np.asarray(slope)).max() > 0.1


def test_what_a_fit_leaves_free_is_cut_off_by_the_most_that_it_may_become():
    """From a start at which all mirror rays would be cut off, with a cutoff that the whole tree of the truth is
    above.
    """
    scene, camera = scene_of("hall of mirrors")
    picture = np.asarray(dw.render(scene, camera, max_depth=4))
    found = fitting.fit(scene.with_cutoff(0.1), picture, ["mirror.k_s"], start={"mirror.k_s": 0.05}, max_depth=4)
    assert found.status == "converged" and found["mirror.k_s"].value == pytest.approx(0.8, abs=1e-4)


def test_a_scene_without_a_cutoff_compiles_none():
    scene, camera = scene_of("hall of mirrors")
    decided = {d.name: (d.on, d.why) for d in dw.decide_effects(scene)}
    assert decided["cutoff"] == (False, "cutoff = 0")
    assert {d.name: d.on for d in dw.decide_effects(scene.with_cutoff(0.01))}["cutoff"]


@pytest.mark.parametrize("cutoff", [-0.1, 1.0, float("nan"), "a", [0.1, 0.2]])
def test_a_cutoff_that_is_none_is_refused(cutoff):
    scene, camera = scene_of("hall of mirrors")
    with pytest.raises(dw.SceneError, match="cutoff"):
        dw.render(scene, camera, cutoff=cutoff)
