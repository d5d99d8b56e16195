"""Options of render, plan, explain and resized that are out of range are one sentence each."""

import jax
import numpy as np
import pytest

import diffwhitted as dw


def scene() -> dw.Scene:
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "m")],
        materials={"m": dw.Material(k_a=0.5, k_d=0.5)},
        lights=[dw.DirectionalLight((0, 0, 1), 1)],
        cameras={"main": dw.Camera((0, 0, 5), (0, 0, 0), 40, 8, 6)},
    )


CAMERA = scene().cameras["main"]


@pytest.mark.parametrize("call", [dw.render, dw.plan, dw.explain])
@pytest.mark.parametrize("depth", [0, -1, 65, 2.5, True, "3"])
def test_max_depth_is_a_whole_number_from_1_to_64(call, depth):
    with pytest.raises(dw.SceneError, match=r"max_depth = .*a whole number from 1 to 64"):
        call(scene(), CAMERA, max_depth=depth)


@pytest.mark.parametrize("samples", [0, -2, 1.5, True, "2"])
def test_samples_is_a_whole_number(samples):
    with pytest.raises(dw.SceneError, match="samples = .*a whole number of 1 or more"):
        dw.render(scene(), CAMERA, samples=samples)


def test_whole_numbers_of_numpy_count():
    np.testing.assert_array_equal(
        dw.render(scene(), CAMERA, samples=np.int64(2), max_depth=np.int32(2)),
        dw.render(scene(), CAMERA, samples=2, max_depth=2),
    )


def test_a_plan_has_its_own_depth():
    with pytest.raises(dw.SceneError, match="max_depth = 3 beside a plan"):
        dw.render(scene(), CAMERA, plan=dw.plan(scene(), CAMERA), max_depth=3)


@pytest.mark.parametrize("name", ["nope.k_s", "m.k_x", "m"])
def test_a_plan_for_an_unknown_coefficient_is_refused(name):
    with pytest.raises(dw.SceneError, match=name.partition(".")[2] or "MATERIAL.COEFFICIENT"):
        dw.plan(scene(), CAMERA, free=(name,))


def test_a_plan_cannot_be_made_of_traced_values():
    with pytest.raises(dw.SceneError, match="outside jit"):
        jax.jit(lambda s: dw.render(s, CAMERA, plan=dw.plan(s, CAMERA)))(scene())


@pytest.mark.parametrize("size", [{"width": 0}, {"height": 0}, {"width": -3}, {"height": 2.5}, {"width": True}])
def test_a_camera_of_no_size_is_refused(size):
    with pytest.raises(dw.SceneError, match=f"{next(iter(size))} = "):
        CAMERA.resized(**size)
