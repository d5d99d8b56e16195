"""Points or pixels: is a target one sample a pixel, or an average over the area of each?

The residual tells. At any coefficients, edges leave far less behind where they are sampled as in the target; what the
next linear step would leave is compared, so that wrong coefficients do not hide it. Where no ray moves, n x n points
need no other program than one.

The mean over a pixel of light that varies smoothly is its value in the middle and half its second derivative times the
second moment of the samples' places, (1 - 1/n^2)/12 along each side for a grid of n x n and 1/12 for the area. A target
does not say which n it has, so the moment is found out as well: the grid is drawn out until what is left over is
least.
"""

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from diffwhitted.tree import sample_places

from ..judging._active import gauss_newton
from ..judging._rest import jacobian_precision
from ..problem._problem import Problem, factorise, prepared
from ..problem._views import at_places, some_passes

LOOKS = 2
"""So many samples along the side of a pixel are enough to find out."""
CLEARLY = 1.1
"""One is taken for better where the other leaves so many times more."""
SIDE = 4
"""Samples along the side of a pixel, of a target that averages over it."""
LEAST_MOMENT, LARGEST_MOMENT = 1 - 1 / SIDE**2, 1.0
"""Of the places of samples, in units of that of the whole pixel: targets have 4 x 4 samples or more."""


@dataclass(frozen=True)
class Comparison:
    """What is left over, RMS in any unit, by one point in the middle of each pixel, and by several."""

    points: float
    pixel: float

    @property
    def better(self) -> str | None:
        """ "points" or "pixel"; None where neither is clearly better."""
        if self.points > CLEARLY * self.pixel:
            return "pixel"
        return "points" if self.pixel > CLEARLY * self.points else None


def compared(problem: Problem, values: np.ndarray) -> Comparison:
    """Both on one pass of each target; the problem may have any number of points a pixel."""
    left = []
    for side in (1, LOOKS):
        few = sampled(replace(problem, views=tuple(some_passes(v, 1) for v in problem.views)), side, values)
        left.append(float(factorise(few, values)[0][-1, -1]))
    return Comparison(*left)


@dataclass(frozen=True)
class Spread:
    """How far from its middle the samples of a pixel stand: the second moment of their places, and its standard
    error.
    """

    moment: float
    error: float


def spread_of(problem: Problem, values: np.ndarray, noise: float) -> Spread | None:
    """The moment that leaves least over after the next linear step; None where the target says nothing of it.

    `noise`: standard deviation of the residuals. What is left over is nearly a parabola in the moment, whose bend says
    how well that is known.
    """
    middle, half = (LEAST_MOMENT + LARGEST_MOMENT) / 2, (LARGEST_MOMENT - LEAST_MOMENT) / 2
    left = [
        float(factorise(sampled(problem, SIDE, values, moment), values)[0][-1, -1] ** 2)
        for moment in (middle - half, middle, middle + half)
    ]
    slope, bend = (left[2] - left[0]) / 2, left[2] - 2 * left[1] + left[0]
    if not (bend > 0 and noise > 0):
        return None
    moment = middle + half * float(np.clip(-slope / bend, -1, 1))
    return Spread(moment, min(noise / (bend / 2) ** 0.5, 1.0) * half)


def moved_by_spread(problem: Problem, values: np.ndarray, spread: Spread) -> np.ndarray:
    """By how much each coefficient would be another, at most, with another moment within its interval, (p,)."""
    ends = np.clip([spread.moment - 2 * spread.error, spread.moment + 2 * spread.error], LEAST_MOMENT, LARGEST_MOMENT)
    steps = []
    for moment in (spread.moment, *ends):
        factor = factorise(sampled(problem, SIDE, values, moment), values)[0]
        steps.append(gauss_newton(factor[:-1, :-1], factor[:-1, -1], jacobian_precision(problem.scene)))
    return np.max([abs(step - steps[0]) for step in steps[1:]], axis=0)


def sampled(problem: Problem, side: int, values: np.ndarray, moment: float | None = None) -> Problem:
    """The problem with side x side points a pixel; `moment`: of their places, that of the grid without one."""
    dtype = problem.scene.dtype
    places = sample_places(side, dtype)
    if moment is not None:
        places = 0.5 + (places - 0.5) * float(moment / (1 - 1 / side**2)) ** 0.5
    views = tuple(at_places(view, places) for view in problem.views)
    views = prepared(problem.scene, problem.nameless, jnp.asarray(problem.all_values(values), dtype), views, False)
    return replace(problem, views=views)
