"""What accuracy costs in a fit: its knobs, errors against the truth, and what is said of them. The command is in
test_tradeoff.
"""

import dataclasses
import inspect

import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from fitting.comparing import _tradeoff_fit
from fitting.comparing._fit_knobs import COMBINATIONS, FIT_KNOBS, FitSettings
from fitting.comparing._tradeoff_fit import CoefficientError, FitPoint, FitTradeoff, recommendation, tradeoff_of_fits
from fitting.problem._bounds import Bounds
from fitting.problem._unknowns import list_unknowns

FREE = ("ball.k_a", "ball.k_d", "ball.phong_exponent")


@pytest.fixture(scope="module")
def scene():
    """A ball that nothing is reflected in."""
    ball = dw.Material(k_a=0.2, k_d=0.6, k_h=0.3, phong_exponent=20)
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "ball")],
        materials={"ball": ball},
        lights=[dw.DirectionalLight((1, 2, 2), (1, 1, 1))],
        cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 40, 24, 18)},
        background=dw.ConstantBackground((0.1, 0.1, 0.3)),
    )


@pytest.fixture(scope="module")
def fits(scene):
    """Of the picture of 2 x 2 points, which is the truth to one setting."""
    picture = np.asarray(dw.render(scene, scene.cameras["main"], samples=2))
    knobs = [
        dataclasses.replace(knob, sweep=(1, 2)) if knob.name == "samples" else knob
        for knob in FIT_KNOBS
        if knob.name != "footprint"
    ]
    said = []
    found = tradeoff_of_fits(
        scene,
        fitting.Target(picture),
        ["ball.k_a", "*.k_d", "*.phong_*"],
        start={"ball.k_d": 0.4},
        knobs=knobs,
        on_work=lambda text, done: said.append(done),
    )
    assert said == sorted(said) and 0 <= said[0] and said[-1] < 1
    return found


# Knobs and settings.


def test_every_row_names_an_argument_of_fit():
    known = inspect.signature(fitting.fit).parameters
    assert [knob.name for knob in FIT_KNOBS if knob.argument is None] == ["cutoff"]
    assert all(knob.argument is None or knob.argument in known for knob in FIT_KNOBS)
    assert all(set(values) <= {knob.name for knob in FIT_KNOBS} for values in COMBINATIONS)


def test_settings_are_those_of_fit_by_default_and_read_as_text(scene):
    plain, moving = (FitSettings.of(scene, moves) for moves in (False, True))
    assert (
        plain.named() == {"depth": 5, "cutoff": 0.0, "samples": 1, "footprint": 0, "coarse_to_fine": True}
        and moving["footprint"] == 1
    )
    assert [str(s) for s in (plain, moving, plain.only(samples=3), moving.only(cutoff=0.25))] == [
        "depth 5, 1 point",
        "depth 5, footprint 1",
        "depth 5, 3 x 3 points",
        "depth 5, cutoff 0.25, footprint 1",
    ]
    assert moving.only(samples=2).arguments() == {"max_depth": 5, "samples": 2, "footprint": 0, "coarse_to_fine": True}


# Fits.


def test_the_truth_is_found_where_the_picture_is_true_and_missed_where_it_is_not(fits):
    by_text = {str(p.settings): p for p in fits.points}
    assert set(by_text) == {"depth 5, 1 point", "depth 5, 2 x 2 points"}
    true, false = by_text["depth 5, 2 x 2 points"], by_text["depth 5, 1 point"]
    assert true.converged and true.largest < 1e-5 < 1e-4 < false.largest
    assert [c.truth for c in true.coefficients] == pytest.approx([0.2, 0.6, 20]) and true.covered == 3
    assert [c.value for c in true.coefficients] == pytest.approx([0.2, 0.6, 20], rel=1e-4)
    assert true.on_front and fits.recommended is true and fits.default == false.settings
    assert all(p.seconds > 0 and p.steps > 1 for p in fits.points) and fits.seconds_compile > 0


def test_fits_start_from_the_middle_of_the_bounds_but_for_what_is_given(fits):
    assert fits.start == pytest.approx({"ball.k_a": 0.5, "ball.k_d": 0.4, "ball.phong_exponent": 1e6**0.5}, rel=1e-5)


def test_errors_are_shares_of_the_bounds_in_the_scale_of_the_fit(scene, fits):
    unknowns = list_unknowns(scene, FREE)
    shares = Bounds(unknowns).shares(jnp.asarray([0.25, 1.0, 1e6**0.25]))
    np.testing.assert_allclose(shares, [0.25, 1.0, 0.25], atol=1e-6)
    for point in fits.points:
        assert point.largest == max(c.of_bounds for c in point.coefficients)
        for c in point.coefficients[:2]:
            assert c.of_bounds == pytest.approx(c.error, abs=1e-6) and c.error == abs(c.value - c.truth)
        exponent = point.coefficients[2]
        assert exponent.of_bounds == pytest.approx(abs(np.log(exponent.value / exponent.truth)) / np.log(1e6), abs=1e-6)


@pytest.mark.parametrize("truth, share", [(0.6, 0.5), (0.45, 0.5), (0.3, 2.0), (0.5, 0.0)])
def test_an_interval_holds_the_truth_up_to_a_share_of_1(truth, share):
    found = fitting.FittedCoefficient("m.k_d", "k_d", 0.5, 0.5, 0.1, (0.4, 0.7), True, True, (), False, (0.0, 1.0), "1")
    assert _tradeoff_fit._of_interval(found, truth) == pytest.approx(share)
    unknown = dataclasses.replace(found, identifiable=False, standard_error=None, interval_95=None)
    assert _tradeoff_fit._of_interval(unknown, truth) is None


def test_ctrl_c_in_one_fit_ends_them_all(scene, monkeypatch):
    class Stopped:
        status = "interrupted"

    monkeypatch.setattr(_tradeoff_fit, "fit", lambda *a, **k: Stopped)
    with pytest.raises(KeyboardInterrupt):
        tradeoff_of_fits(scene, fitting.Target(np.zeros((18, 24, 3))), FREE)


def test_a_depth_at_which_nothing_would_be_seen_of_a_coefficient_is_left_out():
    mirror = dw.Material(k_d=0.5, k_s=0.5, k_h=0.0)
    scene = dw.Scene(
        objects=[dw.Sphere("a", (0, 0, 0), 1, "m"), dw.Sphere("b", (2, 0, 0), 1, "m")], materials={"m": mirror}
    )
    default = FitSettings.of(scene, False)
    for names, depths in ((("m.k_s",), {2, 3, 4, 5, 8, 12}), (("m.k_a",), {1, 2, 3, 4, 5, 8, 12})):
        programs = _tradeoff_fit._programs(scene, names, default, COMBINATIONS, 24 * 18)
        assert {settings["depth"] for settings in programs} == depths
        assert default in programs and programs[default.only(depth=8, footprint=2)] == ["combination"]


# What is said.


def measured(*points):
    """Settings, status, largest error and seconds."""
    made = tuple(
        FitPoint(
            settings, ("depth",), status, 5, seconds, (CoefficientError("m.k_d", 0.5, 0.5 + error, error, error, 0.5),)
        )
        for settings, status, error, seconds in points
    )
    return FitTradeoff(8, 6, made, made[0].settings, {"m.k_d": 0.5}, {"m.k_d": (0.0, 1.0)}, 3, 1.0)


def test_the_recommendation_is_the_cheapest_that_is_nearly_as_good_as_the_best(scene):
    own = FitSettings.of(scene, False)
    points = [
        (own, "converged", 0.1, 0.03),
        (own.only(depth=2), "not_converged", 0.001, 0.04),
        (own.only(footprint=1), "converged", 0.019, 0.12),
        (own.only(footprint=2), "converged", 0.01, 0.3),
    ]
    assert recommendation(measured(*points)) == (
        "For a fit: depth 5, footprint 1: 120 ms, largest error 0.019 of the bounds (m.k_d); the default, depth "
        "5, 1 point, takes 30 ms and errs by 0.1 of the bounds (m.k_d)."
    )
    lost = measured((own, "not_converged", 0.1, 0.03), points[2])
    assert recommendation(lost).endswith("errs by 0.1 of the bounds (m.k_d), and says itself that it is not converged.")
    assert recommendation(measured(points[0])).endswith("; these are the defaults of fit.")
    assert "none converged" in recommendation(measured(points[1]))
