"""What is known besides the pictures: priors, ties, sums that have a limit, and channels that are asked for."""

import json

import numpy as np
import pytest
from scipy.optimize import minimize

import fitting
from diffwhitted import Camera, DirectionalLight, Material, Plane, Scene, Sphere, coefficient_value, render

SHAPE = (18, 24, 3)


def wall(**coefficients) -> Scene:
    """A flat wall that is lit evenly: k_a and k_d cannot be told apart there."""
    return Scene(
        objects=[Plane("w", (0, 0, 1), -1, "m")],
        materials={"m": Material(**({"k_a": 0.1, "k_d": 0.3, "k_h": 0.0} | coefficients))},
        lights=[DirectionalLight((0, 0, 1), 1)],
        cameras={"main": Camera((0, 0, 5), (0, 0, 0), 30, 24, 18)},
        ambient=(1, 1, 1),
    )


def ball(**coefficients) -> Scene:
    material = {"k_a": 0.1, "k_d": 0.5, "k_h": 0.2, "phong_exponent": 20.0} | coefficients
    return Scene(
        objects=[Sphere("s", (0, 0, 0), 1, "m")],
        materials={"m": Material(**material)},
        lights=[DirectionalLight((0.3, 0.5, 1), 1)],
        cameras={"main": Camera((0, 0, 5), (0, 0, 0), 30, 24, 18)},
    )


def picture(scene: Scene) -> np.ndarray:
    return np.asarray(render(scene, scene.cameras["main"]), np.float64)


def noise(size: float, seed: int = 0) -> np.ndarray:
    return size * np.random.default_rng(seed).normal(size=SHAPE)


@pytest.mark.parametrize("given", [0.2, None])
def test_a_prior_counts_for_what_it_says_beside_the_noise(given):
    """One linear number: mean and error of two measurements, the picture's and the prior's."""
    target = picture(ball()) + noise(0.2)
    column = picture(ball(k_a=0.0, k_d=1.0, k_h=0.0))
    error = 0.2 / np.linalg.norm(column)
    measured = 0.5 + (column * noise(0.2)).sum() / (column**2).sum()
    start = {"m.k_d": 0.3}
    prior = (0.45, 0.01)
    result = fitting.fit(ball(), fitting.Target(target, noise=given), ["m.k_d"], start=start, prior={"m.k_d": prior})
    weights = np.array([error**-2, prior[1] ** -2])
    tolerance = 1e-4 if given else 0.05
    expected = weights @ [measured, prior[0]] / weights.sum()
    assert result["m.k_d"].value == pytest.approx(expected, abs=tolerance * 0.05)
    assert result["m.k_d"].standard_error == pytest.approx(weights.sum() ** -0.5, rel=max(tolerance, 1e-3))
    assert result["m.k_d"].sigmas_from_prior == pytest.approx((expected - 0.45) / 0.01, abs=0.1)
    assert "prior 0.45 ± 0.01" in result["m.k_d"].remark
    assert json.loads(json.dumps(result.to_json()))["coefficients"]["m.k_d"]["prior"]["mean"] == 0.45
    plain = np.sum((picture(result.scene) - target) ** 2)  # the prior is no part of the loss
    if given:
        assert result.history[-1].loss == pytest.approx(0.5 * plain / 0.2**2, rel=1e-3)


@pytest.mark.parametrize("size", [0.0, 0.02])
def test_a_prior_determines_what_the_pictures_do_not(size):
    """k_a + k_d = 0.4 is seen; k_a = 0.15 +- 0.02 is known."""
    target = picture(wall()) + noise(size)
    result = fitting.fit(wall(k_a=0.3, k_d=0.6), target, ["m.k_a", "m.k_d"], prior={"m.k_a": (0.15, 0.02)})
    assert result.status == "converged", result.message
    assert result["m.k_a"].value == pytest.approx(0.15, abs=1e-3)
    assert result["m.k_d"].value == pytest.approx(0.25, abs=3e-3)
    for name in ("m.k_a", "m.k_d"):
        assert result[name].standard_error == pytest.approx(0.02, rel=0.02)


@pytest.mark.parametrize(
    "prior, words",
    [
        ({"m.k_a": 0.1}, "mean, standard deviation"),
        ({"m.k_a": (0.1, 0)}, "above 0"),
        ({"m.k_a": (1.5, 0.1)}, "outside its bounds 0 to 1"),
        ({"m.kd": (0.1, 0.1)}, "Did you mean 'm.k_d'"),
    ],
)
def test_a_prior_that_is_none(prior, words):
    with pytest.raises(fitting.FitError, match=words):
        fitting.fit(wall(), picture(wall()), ["m.k_a", "m.k_d"], prior=prior)


def test_a_tied_coefficient_follows_and_both_are_reported():
    """k_a = 0.5 k_d on the wall, which shows their sum 0.4: one unknown with the derivative of both."""
    target = fitting.Target(picture(wall()) + noise(0.02), noise=0.02)
    result = fitting.fit(wall(k_a=0.3, k_d=0.6), target, ["m.k_d"], ties={"m.k_a": "0.5*m.k_d"})
    mean = 0.4 + noise(0.02).mean()
    assert result["m.k_d"].value == pytest.approx(mean / 1.5, abs=1e-4)
    assert result["m.k_a"].value == pytest.approx(mean / 3, abs=1e-4)
    error = 0.02 / np.sqrt(np.prod(SHAPE)) / 1.5
    assert result["m.k_d"].standard_error == pytest.approx(error, rel=1e-3)
    assert result["m.k_a"].standard_error == pytest.approx(error / 2, rel=1e-3)
    assert (result.status, result.rank, result["m.k_a"].tied_to) == ("converged", 1, "m.k_d")
    assert result.correlation[0, 1] == 1
    assert coefficient_value(result.scene, "m.k_a") == pytest.approx(mean / 3, abs=1e-4)


@pytest.mark.parametrize(
    "ties, words",
    [
        ({"m.k_a": "m.k_x"}, "matches no free coefficient"),
        ({"m.k_a": "m.k_a"}, "cannot follow"),
        ({"m.k_a": "0*m.k_d"}, "a factor other than 0"),
        ({"m.k_a": "m.k_d", "m.k_d": "m.k_h"}, "tie both to the last"),
        ({"m.k_a": "-1*m.k_d"}, "within the bounds of both"),
    ],
)
def test_a_tie_that_cannot_be(ties, words):
    with pytest.raises(fitting.FitError, match=words):
        fitting.fit(ball(), picture(ball()), ["m.k_[adh]"], ties=ties)


def test_a_sum_keeps_to_its_limit_as_in_constrained_least_squares():
    """k_a, k_d and k_h of a ball, of which k_a + k_d may be 0.595 where the picture asks for 0.6; against scipy."""
    target = fitting.Target(picture(ball()) + noise(0.02), noise=0.02)
    names = ["m.k_a", "m.k_d", "m.k_h"]
    start = {"m.k_a": 0.2, "m.k_d": 0.2, "m.k_h": 0.1}
    result = fitting.fit(ball(), target, names, start=start, at_most={"m.k_a+m.k_d": 0.595})
    columns = np.stack(
        [picture(ball(**({"k_a": 0.0, "k_d": 0.0, "k_h": 0.0} | {k: 1.0}))).ravel() for k in ("k_a", "k_d", "k_h")], 1
    )
    data = target.image.ravel()
    expected = minimize(
        lambda v: 0.5 * np.sum((columns @ v - data) ** 2),
        [0.2, 0.2, 0.1],
        jac=lambda v: columns.T @ (columns @ v - data),
        constraints={"type": "ineq", "fun": lambda v: 0.595 - v[0] - v[1]},
        options={"ftol": 1e-14},
    ).x
    found = np.array([result[name].value for name in names])
    np.testing.assert_allclose(found, expected, atol=2e-4)
    assert found[0] + found[1] <= 0.595 + 1e-6
    assert result.status == "converged", result.message
    assert "m.k_a + m.k_d is at its limit 0.595" in result["m.k_a"].remark
    # Along the constraint k_d gives what k_a takes.
    along = columns @ np.array([[1, 0], [-1, 0], [0, 1]])
    error = 0.02 * np.sqrt(np.diagonal(np.linalg.inv(along.T @ along)))
    assert result["m.k_a"].standard_error == pytest.approx(error[0], rel=1e-2)
    assert result["m.k_d"].standard_error == pytest.approx(error[0], rel=1e-2)
    assert result["m.k_h"].standard_error == pytest.approx(error[1], rel=1e-2)


def test_a_limit_that_is_not_reached_changes_nothing():
    target = fitting.Target(picture(ball()) + noise(0.02), noise=0.02)
    start = {"m.k_a": 0.2, "m.k_d": 0.2}
    free = fitting.fit(ball(), target, ["m.k_a", "m.k_d"], start=start)
    limited = fitting.fit(ball(), target, ["m.k_a", "m.k_d"], start=start, at_most={"m.k_a+m.k_d": 0.9})
    for name in ("m.k_a", "m.k_d"):
        assert limited[name].value == pytest.approx(free[name].value, abs=1e-5)
        assert limited[name].standard_error == pytest.approx(free[name].standard_error, rel=1e-3)
        assert not limited[name].remark


def test_a_sum_of_colours_is_one_for_each_channel():
    target = picture(ball(k_d=[0.6, 0.4, 0.2]))
    start = {"m.k_a": 0.1, "m.k_d": 0.2}
    result = fitting.fit(ball(k_d=[0.2] * 3), target, ["m.k_a", "m.k_d"], start=start, at_most={"m.k_a+m.k_d": 0.6})
    sums = [result["m.k_a"].value + result[f"m.k_d.{c}"].value for c in "rgb"]
    assert sums[0] == pytest.approx(0.6, abs=1e-4) and max(sums) <= 0.6 + 1e-6 and sums[1] < 0.55
    assert "limit" in result["m.k_d.r"].remark and "limit" not in result["m.k_d.g"].remark


@pytest.mark.parametrize(
    "at_most, words",
    [
        ({"m.k_a": 1}, "allowed is NAME.NAME"),
        ({"m.k_a+m.k_d": "x"}, "allowed is NAME.NAME"),
        ({"m.k_a+m.phong_exponent": 1}, "logarithms"),
        ({"m.k_a+m.k_d": 0}, "come to 0 already"),
        ({"m.k_a+m.k_d": 0.5}, "= 0.6 is above 0.5"),
    ],
)
def test_a_sum_that_cannot_be(at_most, words):
    with pytest.raises(fitting.FitError, match=words):
        fitting.fit(ball(), picture(ball()), ["m.k_[ad]", "m.phong_exponent"], at_most=at_most)


def test_a_number_may_be_looked_for_as_a_colour():
    target = picture(ball(k_d=[0.6, 0.4, 0.2]))
    result = fitting.fit(ball(), target, ["m.k_d"], colour=["m.k_d"], start={"m.k_d": (0.3, 0.5, 0.1)})
    assert [c.start for c in result.coefficients] == pytest.approx([0.3, 0.5, 0.1])
    assert [c.value for c in result.coefficients] == pytest.approx([0.6, 0.4, 0.2], abs=1e-4)


def test_a_free_channel_of_a_number_is_free_alone():
    target = picture(ball(k_d=[0.6, 0.5, 0.5]))
    result = fitting.fit(ball(), target, ["m.k_d.r"])
    assert [c.name for c in result.coefficients] == ["m.k_d.r"]
    np.testing.assert_allclose(coefficient_value(result.scene, "m.k_d"), [0.6, 0.5, 0.5], atol=1e-4)


def test_what_was_sought_as_grey_in_a_coloured_picture_is_said():
    target = picture(ball(k_d=[0.6, 0.4, 0.2])) + noise(0.01)
    assert "m.k_d was sought as one grey number" in (said := fitting.fit(ball(), target, ["m.k_d", "m.k_h"]).message)
    assert "--colour m.k_d)" in said
    assert "grey" not in fitting.fit(ball(), picture(ball(k_d=0.6)) + noise(0.01), ["m.k_d", "m.k_h"]).message


@pytest.mark.parametrize(
    "options, words",
    [
        ({"colour": ["m.phong_exponent"]}, "m.phong_exponent is never three channels"),
        ({"start": {"m.k_d": (0.1, 0.2, 0.3)}}, "--colour"),
    ],
)
def test_a_colour_that_cannot_be(options, words):
    with pytest.raises(fitting.FitError, match=words):
        fitting.fit(ball(), picture(ball()), ["m.k_d"], **options)
