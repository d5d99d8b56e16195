"""`derivative`: a picture with its derivative in one number of the scene, and the passes that it is traced in."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.rendering import _derivative
from references.supersampled import EXAMPLE


@functools.cache
def scene_of():
    scene = dw.load_scene(EXAMPLE.parent / "three_spheres.toml")
    return scene, scene.cameras["main"].resized(40, 30)


def with_k_s(value):
    return dw.replace_coefficient(scene_of()[0], "mirror.k_s", value)


@functools.cache
def in_k_s():
    return dw.derivative(with_k_s, np.full(3, 0.5), scene_of()[1], footprint=0)


def test_it_is_the_derivative_of_the_rendered_picture():
    """All channels of a colour change together; points need no refinement."""
    scene, camera = scene_of()
    plan = dw.plan(scene, camera)
    image, slope = jax.jvp(lambda v: dw.render(with_k_s(v), camera, plan=plan), (jnp.full(3, 0.5),), (jnp.ones(3),))
    found = in_k_s()
    np.testing.assert_allclose(found.image, image, atol=1e-6)
    np.testing.assert_allclose(found.slope, slope, atol=1e-5)
    assert not found.refined.any() and found.rays > 40 * 30


def test_a_tree_larger_than_its_room_is_traced_in_parts(monkeypatch):
    """With room for a quarter of the rays all are traced none the less, and no ray twice."""
    monkeypatch.setattr(_derivative, "likely_room", lambda camera: 40 * 30 // 4)
    found = dw.derivative(with_k_s, np.full(3, 0.5), scene_of()[1], footprint=0)
    np.testing.assert_allclose(found.slope, in_k_s().slope, atol=1e-6)
    assert found.rays == in_k_s().rays


def test_places_and_lamps_have_derivatives_too():
    """Of the ambient light, in which the picture is linear."""
    scene, camera = scene_of()

    def make(ambient):
        return eqx.tree_at(lambda s: s.ambient, scene, jnp.full(3, ambient, scene.dtype))

    found = dw.derivative(make, 1.0, camera, footprint=0)
    np.testing.assert_allclose(
        found.slope, np.asarray(dw.render(make(2.0), camera)) - np.asarray(dw.render(make(1.0), camera)), atol=1e-5
    )


@pytest.mark.parametrize("footprint", [-1, 65, 1.5, True])
def test_a_footprint_that_is_none_is_refused(footprint):
    with pytest.raises(dw.SceneError, match="footprint"):
        dw.derivative(with_k_s, np.full(3, 0.5), scene_of()[1], footprint=footprint)


def test_what_is_no_scene_is_refused():
    with pytest.raises(dw.SceneError, match="make"):
        dw.derivative(lambda value: value, 1.0, scene_of()[1])
