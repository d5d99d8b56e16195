"""Derivatives through moving edges, against central differences of heavily supersampled images.

Pictures are 80x60; `benchmarks/edges.py` measures more scenes, indices and sizes with more samples. A reference of
48 x 48 points and a step of 2e-3 is itself uncertain by 10 to 15 % in L2, which the limits allow for.
"""

import functools

import numpy as np
import pytest

from diffwhitted.accuracy._reference import rmse
from diffwhitted.rendering._passes import traced_passes
from diffwhitted.tree import make_plan
from references.supersampled import SCENES, area_true, changed, cosine, filtered, reference, relative

STEP, SIDE = 2e-3, 48


@functools.cache
def scene_of(name):
    scene = SCENES[name]()
    return scene, scene.cameras["main"].resized(80, 60)


@functools.cache
def in_index(name, step=STEP, seed=0):
    """Image and derivative in the index at 1.5."""
    scene, camera = scene_of(name)
    return reference(lambda d: changed(scene, 1.5 + d, 0.0), camera, step, SIDE, seed)


@pytest.mark.parametrize("name, like, off", [("spheres", 0.98, 0.22)])
def test_one_filtered_tree_has_the_derivative_of_the_area(name, like, off):
    """Cosine, relative L2 error, the image itself, and the gradient of a loss that pulls towards index 1.33."""
    scene, camera = scene_of(name)
    image, slope = in_index(name)
    ours, derivative = filtered(scene, camera)
    assert cosine(derivative, slope) > like and relative(derivative, slope) < off
    assert rmse(ours, image) < 0.006
    away = image - area_true(changed(scene, 1.33, 0.0), camera, 8)
    assert (away * derivative).sum() / (away * slope).sum() == pytest.approx(1, abs=0.05)


def test_the_derivative_of_points_is_another():
    """What the footprint is for: without it derivative and truth have nothing in common."""
    scene, camera = scene_of("spheres")
    image, slope = in_index("spheres")
    points, derivative = filtered(scene, camera, trees=0)
    assert abs(cosine(derivative, slope)) < 0.2 and rmse(points, image) > 0.05


def test_the_reference_has_converged():
    """In the step and in the points: half the step, or other points, change it by less than the limits above."""
    slope = in_index("spheres")[1]
    assert relative(in_index("spheres", STEP / 2)[1], slope) < 0.2
    assert relative(in_index("spheres", seed=1)[1], slope) < 0.2


def test_the_place_of_the_glass_moves_edges_too():
    scene, camera = scene_of("spheres")
    _, slope = reference(lambda d: changed(scene, 1.5, d), camera, 5e-4, SIDE)
    _, derivative = filtered(scene, camera, along=(0.0, 1.0))
    assert cosine(derivative, slope) > 0.95 and relative(derivative, slope) < 0.32
    _, refined = filtered(scene, camera, along=(0.0, 1.0), refine=True)
    assert cosine(refined, slope) > 0.96 and relative(refined, slope) < relative(derivative, slope)


def test_zero_where_nothing_depends_on_the_index():
    _, derivative = filtered(*scene_of("spheres"))
    assert np.all(derivative[:6] == 0) and np.all(derivative[-4:, :8] == 0) and np.any(derivative != 0)


@pytest.mark.parametrize("index", [1.0, 1.0001, 1.1, 2.4, 4.0])
@pytest.mark.parametrize("along", [(1.0, 0.0), (0.0, 1.0)])
def test_derivatives_are_finite_at_any_index(index, along):
    for values in filtered(*scene_of("spheres"), index=index, along=along):
        assert np.isfinite(values).all()


def test_recording_and_replaying_gives_what_tracing_gives():
    scene, camera = scene_of("spheres")
    plan = make_plan(scene, camera, footprint=1, capacity=3 * 80 * 60)
    np.testing.assert_allclose(
        filtered(scene, camera)[0].astype(np.float32), traced_passes(scene, camera, plan)[0], atol=1e-6
    )
