"""How a fit ends: at rest, on a bound, without spare residuals, and what it then says."""

import numpy as np
import pytest

import fitting
from diffwhitted import Camera, DirectionalLight, Material, Plane, Scene, Sphere, render

LIGHT = DirectionalLight((0.3, 0.5, 1), (1, 1, 1))


def scene_of(objects, width=64, height=48, **materials) -> Scene:
    """Objects before a camera on the axis, one directional light, no shadows."""
    return Scene(objects=objects, materials=materials, lights=[LIGHT], shadows="off",
                 cameras={"main": Camera((0, 0, 5), (0, 0, 0), 50, width, height)})


def picture(scene: Scene, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    image = np.asarray(render(scene, scene.cameras["main"]), np.float64)
    return image + noise * np.random.default_rng(seed).normal(size=image.shape)


def ball(size=(64, 48), **coefficients) -> Scene:
    return scene_of([Sphere("s", (0, 0, 0), 1, "m")], *size, m=Material(**({"k_a": 0.3, "k_h": 0.0} | coefficients)))


def wall_and_ball(k_a, k_d, ball_k_d) -> Scene:
    """On the flat wall k_a and k_d cannot be told apart; the ball is clear."""
    return scene_of([Plane("w", (0, 0, 1), -1, "m"), Sphere("s", (0, 0, 0), 0.5, "b")],
                    m=Material(k_a=k_a, k_d=k_d, k_h=0.0), b=Material(k_d=ball_k_d, k_h=0.0))


def test_what_is_determined_is_found_beside_what_is_not():
    """The start is right for the ball and far off for the wall, where only one direction of two is determined."""
    result = fitting.fit(wall_and_ball(0.4, 0.8, 0.6), picture(wall_and_ball(0.1, 0.3, 0.6)), ["m.k_a", "m.k_d", "b.k_d"])
    assert result.rmse < 1e-5
    assert result["b.k_d"].value == pytest.approx(0.6, abs=1e-4)
    assert result["b.k_d"].identifiable
    assert result.status == "not_identifiable"
    assert result["m.k_a"].confounded_with == ("m.k_d",)


@pytest.mark.parametrize("noise", [None, 0.01])
def test_the_sum_of_two_confounded_coefficients_is_found(noise):
    target = fitting.Target(picture(wall_and_ball(0.1, 0.3, 0.6)), noise=noise)
    result = fitting.fit(wall_and_ball(0.4, 0.8, 0.6), target, ["m.k_a", "m.k_d"])
    assert result.rmse < 1e-5
    assert result.status == "not_identifiable"


def test_as_many_residuals_as_unknowns_leave_nothing_to_judge_the_noise_by():
    """One pixel, three channels, three unknowns: found, but without uncertainty."""
    result = fitting.fit(ball((1, 1), k_d=[0.1, 0.1, 0.1]), picture(ball((1, 1), k_d=[0.9, 0.5, 0.7])), ["m.k_d"])
    assert [result[f"m.k_d.{c}"].value for c in "rgb"] == pytest.approx([0.9, 0.5, 0.7], abs=1e-3)
    assert result.status == "converged", result.message
    assert "noise cannot be estimated" in result.message
    assert "do not determine" not in result.message
    assert result["m.k_d.r"].identifiable
    assert result["m.k_d.r"].standard_error is None
    assert np.isnan(result.noise)


@pytest.mark.parametrize("truth, bounds", [(0.0, None), (1.0, None), (0.5, {"m.k_d": (0.1, 0.4)})])
@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_single_coefficient_held_at_its_bound_converges(truth, bounds, seed):
    result = fitting.fit(ball(k_d=0.3), picture(ball(k_d=truth), 0.01, seed), ["m.k_d"], bounds=bounds)
    assert result.status == "converged", result.message
    assert result["m.k_d"].at_bound or abs(result["m.k_d"].value - truth) < 3 * result["m.k_d"].standard_error
    if bounds:
        assert result["m.k_d"].at_bound
