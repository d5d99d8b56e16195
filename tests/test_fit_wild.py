"""Pixels that are not as the model has them: robust losses, and wild pixels that are named and left out."""

import json

import numpy as np
import pytest

import fitting
from diffwhitted import Camera, DirectionalLight, Material, Scene, Sphere, render

NAMES = ["m.k_a", "m.k_d", "m.k_h", "m.phong_exponent"]
TRUTH = {"m.k_a": 0.1, "m.k_d": 0.5, "m.k_h": 0.3, "m.phong_exponent": 40.0}


def ball(**coefficients) -> Scene:
    material = {"k_a": 0.1, "k_d": 0.5, "k_h": 0.3, "phong_exponent": 40.0} | coefficients
    return Scene(
        objects=[Sphere("s", (0, 0, 0), 1, "m")],
        materials={"m": Material(**material)},
        lights=[DirectionalLight((0.3, 0.5, 1), 1)],
        cameras={"main": Camera((0, 0, 5), (0, 0, 0), 28, 32, 24)},
    )


def picture(scene: Scene, size: float = 0.0) -> np.ndarray:
    clean = np.asarray(render(scene, scene.cameras["main"]), np.float64)
    return clean + size * np.random.default_rng(0).normal(size=clean.shape)


def start() -> Scene:
    return ball(k_d=0.3, k_h=0.1, phong_exponent=10.0)


@pytest.mark.parametrize("value", [50.0, 1e30])
@pytest.mark.parametrize("size", [0.0, 0.005])
def test_a_few_wild_pixels_do_not_ruin_a_fit(value, size):
    target = picture(ball(), size)
    places = [(3, 5), (10, 16), (12, 14), (20, 30)]
    for row, column in places:
        target[row, column] = value
    result = fitting.fit(start(), target, NAMES)
    assert result.status == "converged", result.message
    for name, truth in TRUTH.items():
        off = abs(result[name].value - truth)
        assert off < max(4 * result[name].standard_error, 1e-3 * truth)
    assert {(p.row, p.column) for p in result.wild} == set(places) and all(p.left_out for p in result.wild)
    assert result.wild[0].residual == pytest.approx(-value, rel=0.02)
    assert "4 pixels are further off" in result.message and "row 3 column 5" in result.message
    assert "do not determine" not in result.message
    held = json.loads(json.dumps(result.to_json()))["wild"]
    assert len(held) == 4 and held[0]["left_out"] is True


def test_good_pixels_and_sharp_highlights_are_not_wild():
    for scene in (ball(), ball(k_d=0.02, k_h=0.9, phong_exponent=900.0)):
        result = fitting.fit(start(), picture(scene, 0.001), NAMES)
        assert not result.wild and "further off" not in result.message
    assert result["m.phong_exponent"].value == pytest.approx(900, rel=0.05)


def stained(size: float = 0.005) -> np.ndarray:
    """One pixel in ten is brighter by up to 0.5: dust, that no model has."""
    target, random = picture(ball(), size), np.random.default_rng(1)
    where = random.random(target.shape[:2]) < 0.1
    target[where] += random.uniform(0.1, 0.5, (int(where.sum()), 1))
    return target


@pytest.fixture(scope="module")
def squares():
    return fitting.fit(start(), fitting.Target(stained(), noise=0.005), NAMES)


@pytest.mark.parametrize("loss", ["huber", "cauchy", "tukey"])
@pytest.mark.parametrize("noise", [None, 0.005])
def test_a_robust_loss_is_near_the_truth_where_squares_are_not(loss, noise, squares):
    result = fitting.fit(start(), fitting.Target(stained(), noise=noise), NAMES, loss=loss)
    assert result.status in ("converged", "misfit"), result.message
    assert result.loss == loss
    limit = {"huber": 0.012, "cauchy": 0.006, "tukey": 0.004}[loss]
    assert abs(result["m.k_d"].value - 0.5) < limit < abs(squares["m.k_a"].value - 0.1)


@pytest.mark.parametrize("loss", ["huber", "cauchy", "tukey"])
def test_the_standard_errors_of_a_robust_loss_are_those_of_squares_where_the_noise_is_gaussian(loss):
    """95 % efficiency: 1.026 times as large."""
    plain = fitting.fit(start(), picture(ball(), 0.005), NAMES)
    robust = fitting.fit(start(), picture(ball(), 0.005), NAMES, loss=loss)
    for name in NAMES:
        assert robust[name].standard_error == pytest.approx(plain[name].standard_error, rel=0.35)
        assert abs(robust[name].value - plain[name].value) < plain[name].standard_error


def test_a_loss_of_another_name_is_refused():
    with pytest.raises(fitting.FitError, match="loss = 'l1'; allowed is square, huber, cauchy, tukey"):
        fitting.fit(start(), picture(ball()), NAMES, loss="l1")
