"""A k_t of 0 that is traced, or free, is 0 all the same: the picture is that of what is opaque."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw


def two_balls(inner, outer, radius):
    """A ball within a larger one."""
    return dw.Scene(
        objects=[dw.Sphere("inner", (0, 0, 0), 0.7, "inner"), dw.Sphere("outer", (0, 0, 0), radius, "outer")],
        materials={"inner": dw.Material(**inner), "outer": dw.Material(**outer)},
        lights=[dw.PointLight((2, 3, 4), (1, 1, 1))],
        cameras={"main": dw.Camera((0, 0.5, 5), (0, 0, 0), 40, 16, 12)},
        background=dw.GradientBackground((0.2, 0.3, 0.4), (0.6, 0.7, 0.9)),
        max_depth=4,
    )


GLASS = {"k_d": 0.1, "k_t": 0.8, "refractive_index": 1.5}
SCENES = {
    "opaque within glass": two_balls({"k_d": 0.7}, GLASS, 1.2),
    "glass within an opaque room": two_balls(GLASS, {"k_d": 0.7, "refractive_index": 1.3}, 9.0),
}


@eqx.filter_jit
def traced(scene):
    return dw.render(scene, scene.cameras["main"])


@pytest.mark.parametrize("which", SCENES)
def test_the_picture_is_the_same_where_a_coefficient_that_is_zero_is_traced(which):
    scene = SCENES[which]
    image = dw.render(scene, scene.cameras["main"])
    np.testing.assert_allclose(traced(jax.tree.map(jnp.asarray, scene)), image, atol=1e-5)


@pytest.mark.parametrize("which", SCENES)
def test_and_where_it_is_free(which):
    scene = SCENES[which]
    image = dw.render(scene, scene.cameras["main"])
    plan = dw.plan(scene, scene.cameras["main"], free=("inner.k_t", "outer.k_t"))
    np.testing.assert_allclose(dw.render(scene, scene.cameras["main"], plan=plan), image, atol=1e-5)
