"""The cells of codes by a small linear model: certain bounds, and the likelihood of codes."""

import numpy as np
import pytest

from fitting.judging._codes import Cells, bounds_of_polytope, most_likely, standardised
from fitting.judging._evidence import Evidence, jackknife, robust_errors, sandwich


def rounded(noise, seed, step=0.01, count=400, slack=1e-9):
    """Cells of a line a + b x, rounded to a step, near the wrong values (0.3, 0.5) for (0.302, 0.497). `slack`: a
    further deviation, which is known.
    """
    random = np.random.default_rng(seed)
    rows = np.stack([np.ones(count), np.linspace(0, 1, count)], axis=1)
    codes = np.round((rows @ [0.302, 0.497] + np.hypot(noise, slack) * random.normal(size=count)) / step)
    low, high = (codes - 0.5) * step, (codes + 0.5) * step
    return Cells(rows, rows @ [0.3, 0.5], low, high, np.broadcast_to(slack, count), np.ones(count))


def test_exact_codes_bound_with_certainty():
    """The bounds are those of a linear program over all pixels, and hold the truth."""
    from scipy.optimize import linprog

    cells = rounded(0.0, 0)
    found = bounds_of_polytope(cells, np.array([0.1, 0.1]))
    matrix = np.concatenate([cells.jacobian, -cells.jacobian])
    limit = np.concatenate([cells.high - cells.middle, cells.middle - cells.low])
    for k in range(2):
        ends = [linprog(s * np.eye(2)[k], matrix, limit, bounds=(None, None)).x[k] for s in (1, -1)]
        np.testing.assert_allclose(found[k], ends, atol=1e-6)
    assert np.all(found[:, 0] <= [0.002, -0.003]) and np.all([0.002, -0.003] <= found[:, 1])
    assert np.ptp(found, axis=1).max() < 0.01 / 4


def test_codes_with_noise_leave_no_polytope():
    assert bounds_of_polytope(rounded(0.01, 1), np.array([0.1, 0.1])) is None


@pytest.mark.parametrize("noise", [0.002, 0.005, 0.03])
def test_the_likelihood_of_codes_gives_value_noise_and_error(noise):
    """200 pictures: errors have the spread that is said, and the noise before rounding is found."""
    fits = [most_likely(rounded(noise, seed), [np.ones(400)]) for seed in range(200)]
    off = np.stack([fit.change for fit in fits]) - [0.002, -0.003]
    said = np.sqrt(np.mean([np.diagonal(fit.covariance) for fit in fits], axis=0))
    assert off.std(axis=0) == pytest.approx(said, rel=0.15)
    assert np.mean([fit.sigma[0] for fit in fits]) == pytest.approx(noise, rel=0.05)
    cells = rounded(noise, 3)
    true = Cells(cells.jacobian, cells.jacobian @ [0.302, 0.497], cells.low, cells.high, cells.slack, cells.weight)
    z = standardised(true, np.full(400, noise))
    assert abs(z.mean()) < 4 * z.std() / 20


def test_noise_is_found_beside_pixels_that_are_uncertain_by_themselves():
    """A quarter of the pixels, as at edges, by fifteen times the noise: they say nothing of it."""
    slack = np.where(np.arange(400) % 4 == 0, 0.03, 1e-9)
    fits = [most_likely(rounded(0.002, seed, 0.004, slack=slack), [np.ones(400)]) for seed in range(60)]
    sigma = [fit.sigma[1] for fit in fits]
    assert np.median(sigma) == pytest.approx(0.002, rel=0.05) and np.std(sigma) < 0.0003
    off = np.stack([fit.change for fit in fits]) - [0.002, -0.003]
    said = np.sqrt(np.mean([np.diagonal(fit.covariance) for fit in fits], axis=0))
    assert off.std(axis=0) == pytest.approx(said, rel=0.25)


def test_errors_of_groups_are_those_of_correlated_noise():
    """Noise that is the same in squares of 8 pixels: 64 times fewer measurements than pixels."""
    random, errors, values = np.random.default_rng(0), [], []
    for _ in range(150):
        noise = np.kron(random.normal(size=(12, 16)), np.ones((8, 8)))
        mean = noise.mean()
        score = (noise - mean)[..., None]
        piece = np.repeat(np.arange(12), 8)[:, None] * np.ones(128, int)
        grams = np.full((12, 1, 1), 8.0 * 128)
        found = Evidence((score,), (piece,), grams, np.zeros((1, 1)), 1.0)
        errors.append([robust_errors(found, True)[k][0] for k in ("sizes", "blocks of 8", "pieces")])
        values.append(mean)
    white, blocks, pieces = np.mean(errors, axis=0)
    assert np.std(values) == pytest.approx(blocks, rel=0.15) == pytest.approx(pieces, rel=0.2)
    assert white < blocks / 5
    assert sandwich(found, 8).shape == jackknife(found).shape == (1, 1)
