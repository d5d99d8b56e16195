"""Derivatives through moving edges, against central differences of heavily supersampled images.

Pictures are 80x60; `benchmarks/edges.py` measures the same at 160x120 with more samples. A reference of 48 x 48
points and a step of 2e-3 is itself uncertain by 10 to 15 % in L2, which the limits allow for.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from footprint_scenes import SCENES, ball_at, cosine, filtered, reference, relative, rms, with_index

import diffwhitted as dw

STEP, SIDE = 2e-3, 48


def small(scene):
    return scene.cameras["main"].resized(80, 60)


@pytest.fixture(scope="module")
def references():
    """For each scene its image and derivative in the index at 1.5, and the image at 1.33."""
    found = {}
    for name, make in SCENES.items():
        scene = make()
        found[name] = *reference(with_index(scene), small(scene), 1.5, STEP, SIDE), reference(with_index(scene), small(scene), 1.33, STEP, 8)[0]
    return found


LIMITS = {"spheres": (0.98, 0.22), "glass alone": (0.98, 0.22), "smooth": (0.9995, 0.03)}


@pytest.mark.parametrize("name", SCENES)
def test_one_filtered_tree_has_the_derivative_of_the_area(name, references):
    image, slope, target = references[name]
    scene = SCENES[name]()
    ours, derivative = filtered(with_index(scene), small(scene), 1.5)
    assert cosine(derivative, slope) > LIMITS[name][0] and relative(derivative, slope) < LIMITS[name][1]
    assert rms(ours, image) < 0.006
    assert (((ours - target) * derivative).sum() / ((image - target) * slope).sum()) == pytest.approx(1, abs=0.05)


def test_the_derivative_of_points_is_another(references):
    """What the footprint is for: without it the derivative has nothing to do with the truth."""
    scene = SCENES["spheres"]()
    image, slope, _ = references["spheres"]
    points, derivative = filtered(with_index(scene), small(scene), 1.5, trees=0)
    assert abs(cosine(derivative, slope)) < 0.2 and rms(points, image) > 0.05


def test_the_reference_has_converged(references):
    """In the step and in the samples: halving one, or other points, changes it by less than the limits above."""
    scene = SCENES["spheres"]()
    make, camera = with_index(scene), small(scene)
    slope = references["spheres"][1]
    assert relative(reference(make, camera, 1.5, STEP / 2, SIDE)[1], slope) < 0.15
    assert relative(reference(make, camera, 1.5, STEP, SIDE, seed=1)[1], slope) < 0.15


def test_two_by_two_trees_are_nearer_to_the_truth(references):
    scene = SCENES["spheres"]()
    image, slope, _ = references["spheres"]
    ours, derivative = filtered(with_index(scene), small(scene), 1.5, trees=2)
    assert cosine(derivative, slope) > 0.985 and relative(derivative, slope) < 0.17 and rms(ours, image) < 0.003


def test_the_position_of_the_glass(references):
    scene = SCENES["spheres"]()
    _, slope = reference(ball_at(scene), small(scene), 0.0, 5e-4, SIDE)
    _, derivative = filtered(ball_at(scene), small(scene), 0.0)
    assert cosine(derivative, slope) > 0.95 and relative(derivative, slope) < 0.35


def test_reverse_mode_agrees_with_forward_mode():
    scene = SCENES["spheres"]()
    camera = scene.cameras["main"].resized(40, 30)
    plan = dw.plan(scene, camera, footprint=1)
    target = jnp.asarray(dw.render(dw.replace_coefficient(scene, "glass.refractive_index", 1.4), camera, footprint=1))

    def loss(value):
        return ((dw.render(dw.replace_coefficient(scene, "glass.refractive_index", value), camera, plan=plan) - target) ** 2).sum()

    at = jnp.float32(1.5)
    forward = jax.jvp(loss, (at,), (jnp.float32(1),))[1]
    assert jax.grad(loss)(at) == pytest.approx(forward, rel=1e-4)
    difference = (loss(jnp.float32(1.5005)) - loss(jnp.float32(1.4995))) / 1e-3
    assert forward == pytest.approx(difference, rel=0.02)


def test_zero_where_nothing_depends_on_the_index():
    scene = SCENES["spheres"]()
    camera = scene.cameras["main"].resized(40, 30)
    _, derivative = filtered(with_index(scene), camera, 1.5)
    sky_and_near_floor = np.r_[derivative[:3].ravel(), derivative[-2:, :4].ravel()]
    assert np.all(sky_and_near_floor == 0) and np.any(derivative != 0)


@pytest.mark.parametrize("index", [1.0, 1.0001, 1.1, 2.4, 4.0])
def test_derivatives_are_finite_at_any_index(index):
    scene = SCENES["spheres"]()
    image, derivative = filtered(with_index(scene), scene.cameras["main"].resized(40, 30), index)
    assert np.isfinite(image).all() and np.isfinite(derivative).all()
