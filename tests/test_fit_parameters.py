"""Fits of lights, places, sizes and cameras: found from 10 % off; and what no picture can tell apart is named."""

from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from fitting.problem._unknowns import list_unknowns, values_in

ROOT = Path(__file__).parents[1]


def three_spheres(width: int = 80, height: int = 60) -> dw.Scene:
    scene = dw.load_scene(ROOT / "examples/three_spheres_truth.toml")
    camera = scene.cameras["main"].resized(width, height)
    return eqx.tree_at(lambda s: s.cameras["main"], scene, camera)


def off_by(scene: dw.Scene, factors: dict[str, float]) -> dw.Scene:
    for name, factor in factors.items():
        scene = dw.replace_parameter(scene, name, dw.parameter_value(scene, name) * factor)
    return scene


CASES = {
    "lights": (
        ("light.*",),
        {
            "light.light_1.position": 1.1, "light.light_2.position": 0.9,
            "light.light_1.colour": 0.9, "light.light_2.colour": 1.1,
        },
    ),
    "sphere": (
        ("object.left ball.*",),
        {"object.left ball.centre": 1.1, "object.left ball.radius": 0.9},
    ),
    "camera": (
        ("camera.main.vfov_deg", "camera.main.look_from"),
        {"camera.main.vfov_deg": 1.1, "camera.main.look_from": 1.1},
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_what_moves_is_found_from_ten_per_cent_off(case):
    """On a picture of the three spheres by 2 x 2 filtered trees a pixel, which the last steps of the fit trace too."""
    free, factors = CASES[case]
    truth = three_spheres()
    target = np.asarray(dw.render(truth, truth.cameras["main"], footprint=2))
    start = off_by(truth, factors)
    result = fitting.fit(start, target, free)
    assert result.status == "converged", result.message
    expected = values_in(start, list_unknowns(start, result.free), truth)
    for coefficient, value in zip(result.coefficients, expected, strict=True):
        assert coefficient.value == pytest.approx(value, rel=1e-4, abs=1e-4), coefficient.name
        assert coefficient.identifiable and not coefficient.at_bound, coefficient.name
        low, high = coefficient.interval_95
        assert low <= value <= high, coefficient.name
    picture = dw.render(result.scene, result.scene.cameras["main"], footprint=2)
    np.testing.assert_allclose(picture, target, atol=2e-4)


def lit_by_one() -> dw.Scene:
    """Matte things under one light, without ambient light or highlights."""
    return dw.Scene(
        objects=[
            dw.Sphere("ball", (0, 0, 0), 1, "red"),
            dw.Sphere("globe", (1.8, 0.2, -0.5), 0.6, "blue"),
            dw.Plane("ground", (0, 1, 0), -1, "floor"),
        ],
        materials={
            "red": dw.Material(k_d=(0.7, 0.2, 0.1)),
            "blue": dw.Material(k_d=(0.1, 0.2, 0.6)),
            "floor": dw.Material(k_d=(0.5, 0.5, 0.4)),
        },
        lights=[dw.PointLight((3, 5, 4), (0.9, 0.8, 0.7), name="key")],
        cameras={"main": dw.Camera((0, 0.8, 6), (0, 0, 0), 40, 32, 24)},
    )


def test_reflectance_and_light_cannot_be_told_apart():
    """Twice the light and half the reflectance are the same picture, channel by channel."""
    scene = lit_by_one()
    target = np.asarray(dw.render(scene, scene.cameras["main"]))
    start = off_by(scene, {"light.key.colour": 1.1, "red.k_d": 0.8})
    result = fitting.fit(start, target, ["*.k_d", "light.key.colour"])
    assert result.status == "not_identifiable"
    assert (len(result.coefficients), result.rank) == (12, 9)
    for channel in "rgb":
        light = result[f"light.key.colour.{channel}"]
        materials = {f"{name}.k_d.{channel}" for name in ("red", "blue", "floor")}
        assert set(light.confounded_with) == materials and light.standard_error is None
        for name in materials:
            assert f"light.key.colour.{channel}" in result[name].confounded_with
    # What the picture does tell is their product.
    for name in scene.materials:
        product = dw.parameter_value(result.scene, f"{name}.k_d") * dw.parameter_value(result.scene, "light.key.colour")
        expected = dw.parameter_value(scene, f"{name}.k_d") * dw.parameter_value(scene, "light.key.colour")
        np.testing.assert_allclose(product, expected, rtol=1e-4)
    fixed = fitting.fit(start, target, ["*.k_d", "light.key.colour.r"])
    assert {c.name for c in fixed.coefficients if not c.identifiable} == {
        "light.key.colour.r", "red.k_d.r", "blue.k_d.r", "floor.k_d.r"
    }  # fmt: skip


def test_a_camera_that_moves_and_a_scene_that_moves_cannot_be_told_apart():
    """A ball under a light at infinity, and a camera that may go anywhere: only where they are to each other is
    seen.
    """
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0.2, 0.1, 0), 1, "red")],
        materials={"red": dw.Material(k_d=(0.7, 0.4, 0.2), k_a=0.1)},
        lights=[dw.DirectionalLight((1, 2, 2), (0.9, 0.8, 0.7), name="sun")],
        cameras={"main": dw.Camera((0, 0.5, 5), (0, 0, 0), 40, 32, 24)},
        background=dw.ConstantBackground((0.2, 0.3, 0.4)),
    )
    target = np.asarray(dw.render(scene, scene.cameras["main"], footprint=1))
    result = fitting.fit(scene, target, ["object.ball.centre", "camera.main.look_from", "camera.main.look_at"])
    assert result.status == "not_identifiable" and result.rank == 5
    for axis in "xyz":
        ball, camera = result[f"object.ball.centre.{axis}"], result[f"camera.main.look_from.{axis}"]
        assert camera.name in ball.confounded_with and ball.name in camera.confounded_with
        assert not ball.identifiable and not camera.identifiable
    assert result["camera.main.look_at.u"].identifiable and result["camera.main.look_at.v"].identifiable


def test_a_channel_alone_may_be_free():
    scene = lit_by_one()
    target = np.asarray(dw.render(scene, scene.cameras["main"]))
    start = dw.replace_parameter(scene, "red.k_d.g", 0.5)
    result = fitting.fit(start, target, ["red.k_d.g"], bounds={"red.k_d.g": (0.1, 0.9)}, start={"red.k_d.g": 0.7})
    assert result.free == ("red.k_d.g",) and len(result.coefficients) == 1
    assert result["red.k_d.g"].value == pytest.approx(0.2, abs=1e-5)
    assert result["material.red.k_d.g"].bounds == (0.1, 0.9)
    np.testing.assert_allclose(dw.parameter_value(result.scene, "red.k_d"), (0.7, 0.2, 0.1), atol=1e-5)


def test_ambient_light_and_background_are_found_from_nothing():
    """Each is 0 at the start; a background of 0 and an ambient light of 0 stay in the picture's program all the
    same.
    """
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "red")],
        materials={"red": dw.Material(k_a=(0.5, 0.2, 0.1))},
        cameras={"main": dw.Camera((0, 0.5, 5), (0, 0, 0), 40, 32, 24)},
        background=dw.GradientBackground((0.2, 0.3, 0.4), (0.5, 0.6, 0.7)),
        ambient=(0.9, 0.6, 0.3),
    )
    target = np.asarray(dw.render(scene, scene.cameras["main"]))
    start = off_by(scene, {"scene.ambient": 0, "background.top": 0, "background.bottom": 0})
    result = fitting.fit(start, target, ["scene.ambient", "background.*"])
    assert result.status == "converged", result.message
    for name in ("scene.ambient", "background.top", "background.bottom"):
        np.testing.assert_allclose(
            dw.parameter_value(result.scene, name), dw.parameter_value(scene, name), atol=1e-5, err_msg=name
        )
