"""Pictures of whole numbers: each pixel lies within the cell of its code, and the coefficients within what all allow.

Least squares takes the middle of a cell for the value. Where the picture is flat, that error is one and not many, the
fit absorbs it, and no residual shows it. What is true is lo <= value <= hi for each pixel. Near the solution values are
m + J d, so:

- Without other noise the coefficients lie in a polytope, two half spaces a pixel. Its least and largest value of each
  coefficient, by linear programs, are certain bounds.
- With noise sigma before rounding the likelihood of a code is Phi((hi - m)/sigma) - Phi((lo - m)/sigma)
  (interval-censored regression). It is log-concave in m: Newton's method finds its maximum, and its curvature is the
  information from which the standard errors come.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ._normal import normal_inverse

STEPS = 40
VIOLATED = 64
"""So many of the constraints that are violated most are added at a time."""
SLACK = 1e-5
"""A polytope counts as there if no pixel is further from its cell than this share of the cell."""
LEAST = 0.02
"""The noise before rounding is not taken for less than this share of a cell."""


@dataclass(frozen=True)
class Cells:
    """The values of the pixels near the solution, and between which ends each lies; one a channel and pixel."""

    jacobian: np.ndarray
    """(n, p)."""
    middle: np.ndarray
    """(n,), the model at the solution."""
    low: np.ndarray
    high: np.ndarray
    slack: np.ndarray
    """What the model itself is uncertain by (edges, arithmetic), (n,)."""
    weight: np.ndarray
    """1, or 1/3 of three equal channels."""

    @property
    def width(self) -> np.ndarray:
        """Of each cell; twice the half that is there, of one without an end."""
        whole = self.high - self.low
        return np.where(np.isfinite(whole), whole, np.nanmax(np.where(np.isfinite(whole), whole, np.nan)))


def bounds_of_polytope(cells: Cells, size: np.ndarray) -> np.ndarray | None:
    """The least and the largest d of each coefficient that all pixels allow, (p, 2); None where they allow none.

    `size`: by how much each coefficient may change at most, for the scale of the programs.
    """
    scaled = cells.jacobian * size
    low = cells.low - cells.middle - cells.slack - SLACK * cells.width
    high = cells.high - cells.middle + cells.slack + SLACK * cells.width
    program = _Program(scaled, low, high)
    if not program.feasible():
        return None
    count, ends = scaled.shape[1], []
    for k in range(count):
        least, largest = (program.solved(sign * np.eye(count)[k]) for sign in (1.0, -1.0))
        if least is None or largest is None:
            return None
        ends.append([least[k] * size[k], largest[k] * size[k]])
    return np.asarray(ends)


class _Program:
    """Linear programs over the same many constraints, of which only those that matter are handed on."""

    def __init__(self, rows: np.ndarray, low: np.ndarray, high: np.ndarray):
        self.rows, self.low, self.high = rows, low, high
        near = np.minimum(-low, high)
        self.working = set(np.argsort(near)[: 4 * VIOLATED].tolist())

    def feasible(self) -> bool:
        return bool((self.low <= self.high).all()) and self.solved(np.zeros(self.rows.shape[1])) is not None

    def solved(self, cost: np.ndarray) -> np.ndarray | None:
        """Where the cost is least; None where the constraints leave no place."""
        from scipy.optimize import linprog

        for _ in range(STEPS):
            chosen = np.fromiter(self.working, int)
            rows, low, high = self.rows[chosen], self.low[chosen], self.high[chosen]
            below, above = np.isfinite(low), np.isfinite(high)
            matrix, limit = np.concatenate([rows[above], -rows[below]]), np.concatenate([high[above], -low[below]])
            # Rows of one length: the programs' tolerance is absolute.
            length = np.maximum(np.linalg.norm(matrix, axis=1), 1e-12)
            found = linprog(cost, matrix / length[:, None], limit / length, bounds=(-1, 1), method="highs")
            if found.status != 0:
                return None
            value = self.rows @ found.x
            over = np.maximum(value - self.high, self.low - value) / np.maximum(self.high - self.low, 1e-12)
            over[~np.isfinite(over)] = 0
            worst = np.argsort(-over)[:VIOLATED]
            worst = [int(k) for k in worst if over[k] > 1e-6 and k not in self.working]
            if not worst:
                return found.x
            self.working.update(worst)
        return None


@dataclass(frozen=True)
class Censored:
    """The maximum of the likelihood of the codes."""

    change: np.ndarray
    """From the solution, (p,)."""
    sigma: np.ndarray
    """Noise before rounding, (n,)."""
    covariance: np.ndarray
    likelihood: float
    """Its logarithm."""


def most_likely(cells: Cells, shapes: Sequence[np.ndarray]) -> Censored:
    """The coefficients and the noise before rounding that make the codes most likely, whose standard deviations go as
    one of the shapes, (n,), such as ones.
    """
    return max((_most_likely(cells, shape) for shape in shapes), key=lambda found: found.likelihood)


def _most_likely(cells: Cells, shape: np.ndarray) -> Censored:
    count = cells.jacobian.shape[1]
    change, least = np.zeros(count), LEAST * float(np.average(cells.width / shape, weights=cells.weight))
    inside = np.where(np.isfinite(cells.low) & np.isfinite(cells.high), (cells.low + cells.high) / 2, cells.middle)
    share = max(float(np.sqrt(np.average(((inside - cells.middle) / shape) ** 2, weights=cells.weight))), 2 * least)
    for _ in range(STEPS):
        sigma = np.hypot(share * shape, cells.slack)
        score, information, _ = _likelihood(cells, change, sigma)
        gram = (cells.jacobian * (information * cells.weight)[:, None]).T @ cells.jacobian
        step = _inverse(gram) @ (cells.jacobian.T @ (score * cells.weight))
        change = change + step
        new = _likeliest_noise(cells, change, shape, least, max(4 * share, 2 * least))
        settled = abs(new / share - 1) < 1e-3 and np.all(abs(step) ** 2 <= 1e-6 * np.diagonal(_inverse(gram)))
        share = new
        if settled:
            break
    sigma = np.hypot(share * shape, cells.slack)
    _, information, logs = _likelihood(cells, change, sigma)
    gram = (cells.jacobian * (information * cells.weight)[:, None]).T @ cells.jacobian
    return Censored(change, sigma, _inverse(gram), float(np.sum(logs * cells.weight)))


def _likeliest_noise(cells: Cells, change: np.ndarray, shape: np.ndarray, least: float, most: float) -> float:
    """The noise that makes the codes most likely with these coefficients.

    Looked for itself: the mean square of the hidden values, step by step (EM), hardly moves where noise is less than a
    cell, and stops at too much of it.
    """
    from scipy.optimize import minimize_scalar

    def unlikely(log_share: float) -> float:
        sigma = np.hypot(np.exp(log_share) * shape, cells.slack)
        return -float(np.sum(_likelihood(cells, change, sigma)[2] * cells.weight))

    ends = (float(np.log(least)), float(np.log(most)))
    found = minimize_scalar(unlikely, bounds=ends, method="bounded", options={"xatol": 1e-3})
    return float(np.exp(found.x))


def standardised(cells: Cells, sigma: np.ndarray) -> np.ndarray:
    """What is left over, (n,), with mean 0 where the model is right, whatever the cells: sigma times the derivative of
    each pixel's likelihood in its value.
    """
    return sigma * _likelihood(cells, np.zeros(cells.jacobian.shape[1]), sigma)[0]


def _likelihood(cells: Cells, change: np.ndarray, sigma: np.ndarray):
    """Derivative and minus the second derivative of the logarithm of each pixel's likelihood in its value."""
    from scipy.special import log_ndtr

    model = cells.middle + cells.jacobian @ change
    a, b = (np.clip((end - model) / sigma, -30, 30) for end in (cells.low, cells.high))
    # On the side where the tail is, for the digits of the difference.
    flipped = a + b > 0
    lower, upper = np.where(flipped, -b, a), np.where(flipped, -a, b)
    log_upper, log_lower = log_ndtr(upper), log_ndtr(lower)
    log_mass = log_upper + np.log(-np.expm1(np.minimum(log_lower - log_upper, -1e-15)))
    density_a, density_b = (np.exp(-0.5 * end**2 - 0.5 * np.log(2 * np.pi) - log_mass) for end in (a, b))
    first = (density_a - density_b) / sigma
    second = first**2 + (b * density_b - a * density_a) / sigma**2
    return first, np.maximum(second, 0), log_mass


def _inverse(gram: np.ndarray) -> np.ndarray:
    return normal_inverse(gram, 1e-9)
