"""What only shows while a program runs: no callback in it, and NaN in place of a wrong picture."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.rendering._unforeseen import poisoned, unforeseen
from diffwhitted.tree import make_plan

DARK = dict(k_a=0.0, k_d=0.0, k_h=0.0)


def scene_of(ball: dict, *, floor: dict = DARK, ambient: float = 0.0, shadows: str = "opaque", cutoff: float = 0.0):
    return dw.Scene(
        objects=[
            dw.Sphere("ball", (0, 0, 0), 1, "ball"),
            dw.Sphere("core", (0, 0, 0), 0.5, "core"),
            dw.Plane("floor", (0, 1, 0), -1, "floor"),
        ],
        materials={
            "ball": dw.Material(**DARK | ball),
            "core": dw.Material(**DARK),
            "floor": dw.Material(k_d_texture="tiles", **floor),
        },
        textures={"tiles": dw.Checker([(1, 1, 1), (0, 0, 0)], 1.0)},
        lights=[dw.PointLight((2, 4, 3), 1.0)],
        cameras={"main": dw.Camera((0, 0.5, 5), (0, 0, 0), 40, 8, 6)},
        ambient=ambient,
        shadows=shadows,
        max_depth=3,
        cutoff=cutoff,
    )


# What was there when the plan was made, the number that changes, and its new value.
GLASS = dict(k_t=0.5, refractive_index=1.0)
CASES = {
    "ambient": (dict(k_a=0.5), "ambient", 0.2),
    "diffuse": ({}, "ball.k_d", 0.3),
    "highlight": (dict(k_d=0.5), "ball.k_h", 0.3),
    "reflection": (dict(k_d=0.5), "ball.k_s", 0.3),
    "refraction": (dict(k_d=0.5, k_s=0.2), "ball.k_t", 0.3),
    "total_internal_reflection": (GLASS, "ball.refractive_index", 1.3),
    "nested_media": (GLASS, "core.k_t", 0.3),
    "textures": (dict(k_d=0.5), "floor.k_d", 0.3),
    "cutoff": (GLASS, "cutoff", 0.1),
}


@pytest.mark.parametrize("case", CASES)
def test_a_number_that_outgrows_the_plan_is_seen(case):
    given, name, value = CASES[case]
    scene = scene_of(given)
    plan = make_plan(scene, scene.cameras["main"])
    assert not getattr(plan.effects, case, False)
    if name in ("ambient", "cutoff"):
        where = (lambda s: s.ambient) if name == "ambient" else (lambda s: s.cutoff)
        changed = eqx.tree_at(where, scene, jnp.full_like(where(scene), value))
    else:
        changed = dw.replace_coefficient(scene, name, value)
    assert not unforeseen(scene, plan)
    assert unforeseen(changed, plan)
    assert not unforeseen(changed, make_plan(changed, changed.cameras["main"]))


def test_what_cannot_be_seen_calls_for_nothing():
    """No light, one level, a material that nothing is made of: the plan leaves these out, and they stay unseen."""
    scene = scene_of(dict(k_d=0.5))
    flat = make_plan(scene, scene.cameras["main"], max_depth=1)
    assert not unforeseen(dw.replace_coefficient(scene, "ball.k_s", 0.5), flat)
    dark = eqx.tree_at(lambda s: s.lights, scene_of({}), ())
    assert not unforeseen(dw.replace_coefficient(dark, "ball.k_d", 0.5), make_plan(dark, dark.cameras["main"]))


def test_a_stale_plan_makes_picture_and_derivatives_nan():
    """A plan made at k_s = 0, the whole scene traced with 0.3 in it: the mirror ray is not in the program."""
    scene = scene_of(dict(k_d=0.5, k_h=0.2))
    camera = scene.cameras["main"]
    plan = dw.plan(scene, camera)

    @eqx.filter_jit
    def both(scene):
        loss = eqx.filter_value_and_grad(lambda scene: dw.render(scene, camera, plan=plan).mean())
        return dw.render(scene, camera, plan=plan), loss(scene)

    picture, (loss, slopes) = both(scene)
    np.testing.assert_allclose(picture, dw.render(scene, camera), atol=1e-6)
    assert np.isfinite(loss) and all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(slopes))
    picture, (loss, slopes) = both(dw.replace_coefficient(scene, "ball.k_s", 0.3))
    assert np.isnan(picture).all() and np.isnan(loss)
    assert all(np.isnan(leaf).all() for leaf in jax.tree.leaves(slopes))


@pytest.mark.parametrize("wrong", [False, True])
def test_the_derivatives_of_a_poisoned_picture(wrong):
    """Those of the image itself, or NaN in every number that is given, also where the image does not depend on it."""

    def image(used, unused):
        return poisoned(jnp.full((1, 2, 3), 2.0) * used, (used, unused), jnp.bool_(wrong)).sum()

    for mode in (jax.jacfwd, jax.jacrev):
        found = np.asarray(mode(image, argnums=(0, 1))(0.5, 0.25))
        np.testing.assert_array_equal(found, (np.nan, np.nan) if wrong else (12.0, 0.0))


def test_no_program_calls_back_to_the_host():
    """A callback keeps a program out of every cache of compiled programs."""
    scene = scene_of(dict(k_s=0.5, k_t=0.4))
    camera = scene.cameras["main"]
    for plan in (None, dw.plan(scene, camera, free=("ball.k_d",))):

        def loss(value, plan=plan):
            return dw.render(dw.replace_coefficient(scene, "ball.k_d", value), camera, plan=plan).mean()

        assert "callback" not in jax.jit(jax.value_and_grad(loss)).lower(0.5).as_text()


@pytest.mark.parametrize("transform", [jax.jit, jax.vmap])
def test_a_fit_of_traced_pictures_is_refused(transform):
    scene = scene_of(dict(k_d=0.5))
    with pytest.raises(fitting.FitError, match="traced.*outside jax.jit"):
        transform(lambda picture: fitting.fit(scene, picture, ["ball.k_d"]).loss)(jnp.zeros((2, 6, 8, 3)))


def test_a_plan_of_more_serves_a_scene_that_calls_for_less():
    """The plan has textures; what wears them is black now. Ambient light alone is left: k_a I_a, by hand."""

    def floor(k_d: float) -> dw.Scene:
        return dw.Scene(
            objects=[dw.Plane("floor", (0, 1, 0), 0, "floor")],
            materials={"floor": dw.Material(k_a=0.25, k_d=k_d, k_d_texture="tiles")},
            textures={"tiles": dw.Checker(((0, 0, 0), (1, 1, 1)))},
            lights=[dw.PointLight((0, 3, 0), (1, 1, 1))],
        )

    camera = dw.Camera((0, 2, 0), (0, 0, -0.1), 30, 8, 6)
    plan = dw.plan(floor(0.5), camera)
    np.testing.assert_allclose(dw.render(floor(0.0), camera, plan=plan), 0.25, rtol=1e-6)
