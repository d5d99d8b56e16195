"""The solver, on linear residuals whose loss is known to so many digits only."""

import numpy as np
import pytest

import diffwhitted as dw
from fitting.problem._bounds import Bounds
from fitting.problem._problem import Problem
from fitting.problem._unknowns import list_unknowns
from fitting.solving import _solve

TRUTH = np.array([0.3, 0.6])
FACTOR = np.diag([1.0, 0.1])


@pytest.fixture
def problem(monkeypatch):
    """Each look finds a loss that is a little larger than it should be, more so each time, and a gradient that is
    right.
    """
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "ball")],
        materials={"ball": dw.Material(k_d=0.5, k_h=0.5)},
        lights=[dw.PointLight((0, 3, 0), 1)],
    )
    unknowns, looks = list_unknowns(scene, ["ball.k_d", "ball.k_h"]), []

    def factorise(problem, values, sigma):
        looks.append(values)
        found = np.zeros((3, 3))
        found[:2, :2], found[:2, 2], found[2, 2] = (
            FACTOR,
            FACTOR @ (np.asarray(values, np.float64) - TRUTH),
            1 + 1.5e-7 * len(looks),
        )
        return found, ()

    monkeypatch.setattr(_solve, "factorise", factorise)
    return Problem(scene, Bounds(unknowns), (), unknowns)


def near(limit):
    return lambda values, factor, remainder, loss: bool(np.all(abs(values - TRUTH) < limit))


def test_steps_too_small_for_the_loss_are_judged_by_their_promise(problem, monkeypatch):
    start = np.array([0.8, 0.2])
    found = _solve.solve(problem, start, max_steps=60, at_rest=near(1e-5))
    np.testing.assert_allclose(found.values, TRUTH, atol=1e-5)
    assert found.history[-1].accepted and len(found.history) < 20
    monkeypatch.setattr(_solve, "UNSEEN", 0.0)
    blind = _solve.solve(problem, start, max_steps=60, at_rest=near(1e-5))
    assert abs(blind.values - TRUTH).max() > 1e-4  # what the loss alone leads to


def test_a_run_goes_on_with_the_boldness_of_the_one_before(problem):
    start = np.array([0.8, 0.2])
    first = _solve.solve(problem, start, max_steps=60, at_rest=near(1e-2))
    again, bold = (
        _solve.solve(problem, start, max_steps=60, at_rest=near(1e-2), boldness=b) for b in (None, first.boldness)
    )
    assert first.boldness > 1 and len(bold.history) < len(again.history)


def test_a_coefficient_at_its_bound_does_not_keep_the_others_from_rest(problem, monkeypatch):
    """The truth of the second lies beyond its bound."""
    monkeypatch.setattr("test_solve.TRUTH", np.array([0.3, 1.5]))
    found = _solve.solve(problem, np.array([0.8, 0.2]), max_steps=60)
    assert found.values[0] == pytest.approx(0.3, abs=1e-3) and found.values[1] == pytest.approx(1, abs=1e-3)
