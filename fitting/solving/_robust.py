"""Losses that let large residuals count for less: weights of iteratively re-weighted least squares.

With z = r / s and s from the data, 1.4826 times the median of |r|, the solve that follows has the weights w(z), with
which its stationary points are those of the loss: Huber's min(1, c/|z|), Cauchy's 1/(1 + (z/c)^2), Tukey's (1 -
(z/c)^2)^2 within c and 0 beyond. Each c loses 5 % of efficiency where the noise is Gaussian (Holland and Welsch 1977).
"""

from collections.abc import Callable, Sequence

import numpy as np

from ..problem._target import CheckedTarget
from ..problem._weighing import Weighing
from ..problem._whole_pictures import brightness, of_used, shown_by
from ._solve import Solution

LOSSES: dict[str, float] = {"huber": 1.345, "cauchy": 2.385, "tukey": 4.685}
"""The size c, in standard deviations, from which on residuals count for clearly less."""
MEDIAN = 1.4826
"""Standard deviations of a Gaussian for each median of its size."""
LEAST = 1e-6
"""A weight of 0 is so much: a deviation stays finite."""
HUBER_ROUNDS = 4
"""Tukey's loss has several valleys: so many rounds of Huber's, which has one, lead to one that is near."""


def weights_of(loss: str, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """w(z), and the derivative of z w(z)."""
    u = np.abs(z) / LOSSES[loss]
    if loss == "huber":
        return 1 / np.maximum(u, 1), (u < 1).astype(np.float64)
    if loss == "cauchy":
        return 1 / (1 + u**2), (1 - u**2) / (1 + u**2) ** 2
    within = u < 1
    return np.where(within, (1 - u**2) ** 2, 0), np.where(within, (1 - u**2) * (1 - 5 * u**2), 0)


def reweighed(
    loss: str, targets: Sequence[CheckedTarget], weighing: Weighing, first: Weighing, solution: Solution, eps: float
) -> Weighing:
    """The deviations by which residuals of this solution count as the loss says. `first`: the noise that was given, or
    a unit.
    """
    shown = shown_by(targets, solution.films)
    z = [(p - t.image) / d for p, t, d in zip(shown, targets, first.deviations, strict=True)]
    scale = max(robust_scale(of_used(targets, z)), eps * brightness(targets) / first.unit)
    slope: Callable[[np.ndarray], np.ndarray] = lambda standard: weights_of(loss, standard)[1]  # noqa: E731
    weights = [np.maximum(weights_of(loss, part / scale)[0], LEAST) for part in z]
    # A noise that was given stays what it is; one that was not is what the residuals show.
    size = 1.0 if targets[0].noise is not None else scale
    deviations = tuple(size * d / np.sqrt(w) for d, w in zip(first.deviations, weights, strict=True))
    standard = of_used(targets, z) / scale
    slack = float(of_used(targets, weights).mean() / max(slope(standard).mean(), 0.3))
    return Weighing(deviations, weighing.total, True, max(slack, 1.0), robust=True)


def robust_scale(residual: np.ndarray) -> float:
    """The standard deviation that the middle of the residuals shows."""
    return MEDIAN * float(np.median(np.abs(residual)))
