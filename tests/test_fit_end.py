"""How a fit ends: at rest, on a bound, without spare residuals, and what it then says."""

import numpy as np
import pytest

import fitting
from diffwhitted import Camera, DirectionalLight, Material, Plane, Scene, Sphere, render

LIGHT = DirectionalLight((0.3, 0.5, 1), (1, 1, 1))


def scene_of(objects, width=64, height=48, **materials) -> Scene:
    """Objects before a camera on the axis, one directional light, no shadows."""
    return Scene(
        objects=objects,
        materials=materials,
        lights=[LIGHT],
        shadows="off",
        cameras={"main": Camera((0, 0, 5), (0, 0, 0), 50, width, height)},
    )


def picture(scene: Scene, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    image = np.asarray(render(scene, scene.cameras["main"]), np.float64)
    return image + noise * np.random.default_rng(seed).normal(size=image.shape)


def ball(size=(64, 48), **coefficients) -> Scene:
    return scene_of([Sphere("s", (0, 0, 0), 1, "m")], *size, m=Material(**({"k_a": 0.3, "k_h": 0.0} | coefficients)))


def wall_and_ball(k_a, k_d, ball_k_d) -> Scene:
    """On the flat wall k_a and k_d cannot be told apart; the ball is clear."""
    return scene_of(
        [Plane("w", (0, 0, 1), -1, "m"), Sphere("s", (0, 0, 0), 0.5, "b")],
        m=Material(k_a=k_a, k_d=k_d, k_h=0.0),
        b=Material(k_d=ball_k_d, k_h=0.0),
    )


def test_what_is_determined_is_found_beside_what_is_not():
    """The start is right for the ball and far off for the wall, where only one direction of two is determined."""
    result = fitting.fit(
        wall_and_ball(0.4, 0.8, 0.6), picture(wall_and_ball(0.1, 0.3, 0.6)), ["m.k_a", "m.k_d", "b.k_d"]
    )
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


def smooth_noise(shape, size: float, seed: int) -> np.ndarray:
    """White noise averaged over 2 x 2 pixels: neighbours have a correlation of one half."""
    white = np.random.default_rng(seed).normal(size=shape)
    mean = (white + np.roll(white, 1, 0) + np.roll(white, 1, 1) + np.roll(white, (1, 1), (0, 1))) / 2
    return size * mean


@pytest.mark.parametrize("noise", [None, 0.02])
@pytest.mark.parametrize("seed", range(5))
def test_white_noise_is_no_misfit(seed, noise):
    target = fitting.Target(picture(ball(k_d=0.7), 0.02, seed), noise=noise)
    result = fitting.fit(ball(k_d=0.3), target, ["m.k_d", "m.k_a"])
    assert not result.misfit
    assert "not noise" not in result.message


@pytest.mark.parametrize("heavy", ["outliers", "per pixel"])
def test_noise_of_other_kinds_is_no_misfit(heavy):
    """One pixel in a hundred ten times as far off; and one noise common to the three channels."""
    random, clean = np.random.default_rng(3), picture(ball(k_d=0.7))
    noise = random.normal(size=(48, 64, 1)) * np.ones(3) if heavy == "per pixel" else random.standard_t(2, clean.shape)
    assert not fitting.fit(ball(k_d=0.3), clean + 0.01 * noise, ["m.k_d", "m.k_a"]).misfit


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_what_is_fixed_and_wrong_is_a_misfit(noise):
    """The target has a highlight, the scene has none."""
    result = fitting.fit(ball(k_d=0.3), picture(ball(k_d=0.7, k_h=0.2, phong_exponent=10.0), noise), ["m.k_d", "m.k_a"])
    assert result.misfit
    assert result.status == "misfit" and result.exit_code == 1 and "the model does not fit" in result.message
    assert result.to_json()["misfit"] is True


def test_noise_with_a_grain_widens_the_intervals():
    """Of neighbours that agree a picture holds less: the intervals are wider than those of as much white noise."""
    clean, names = picture(ball(k_d=0.7)), ["m.k_d", "m.k_a"]
    white = fitting.fit(ball(k_d=0.3), picture(ball(k_d=0.7), 0.01), names)
    for seed in range(3):
        result = fitting.fit(ball(k_d=0.3), clean + smooth_noise(clean.shape, 0.01, seed), names)
        assert not result.misfit and "the intervals allow for it" in result.message
        assert all(result[name].standard_error > 1.4 * white[name].standard_error for name in names)


def test_a_residual_above_the_given_noise_is_a_misfit_and_one_below_is_not():
    noisy, wrong = picture(ball(k_d=0.7), 0.02), picture(ball(k_d=0.7, k_h=0.02, phong_exponent=10.0))
    assert fitting.fit(ball(k_d=0.3), fitting.Target(noisy, noise=0.005), ["m.k_d"]).misfit
    assert not fitting.fit(ball(k_d=0.3), fitting.Target(wrong, noise=0.1), ["m.k_d"]).misfit
    assert fitting.fit(ball(k_d=0.3), wrong, ["m.k_d"]).misfit


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_rounding_is_neither_noise_nor_misfit_and_bounds_the_standard_error(precision):
    def exact(k_d):
        like = ball()
        return Scene(
            objects=like.objects,
            materials={"m": Material(k_a=0.3, k_d=k_d, k_h=0.0)},
            lights=like.lights,
            cameras=like.cameras,
            precision=precision,
        )

    result = fitting.fit(exact(0.3), picture(exact(0.7)), ["m.k_d", "m.k_a"])
    assert not result.misfit
    assert result.at_rounding_level
    for coefficient in result.coefficients:
        assert coefficient.standard_error >= 4 * np.finfo(precision).eps * coefficient.value
        low, high = coefficient.interval_95
        assert high - low >= 14 * np.finfo(precision).eps * coefficient.value
    assert result["m.k_d"].interval_95[0] < 0.7 < result["m.k_d"].interval_95[1]
