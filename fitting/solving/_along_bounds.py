"""Gauss-Newton steps along bounds and sums, where the solver's unknowns have no slope."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import jax.numpy as jnp
import numpy as np

from .._result import FitStep
from ..judging._active import active_step
from ..judging._rest import near_bounds
from ..problem._problem import Problem

if TYPE_CHECKING:
    from ._solve import Look

SLOW, HARDLY = 4, 3e-3
"""So many steps that lower the loss by no more than this share of it are enough where a bound holds something."""
STRAIGHT, FURTHEST = 0.95, 20.0
"""Steps with this cosine between them have one direction; none is made longer than so many times."""


def promise(problem: Problem, here: Look) -> tuple[np.ndarray, float]:
    """The next Gauss-Newton step, and by how much the linear model says that it lowers the loss; what is held
    goes onto its bound.
    """
    values, factor, remainder, _ = here.linear()
    seen, precision = np.linalg.norm(factor, axis=0) > 0, float(jnp.finfo(problem.scene.dtype).eps) ** 0.7
    step, held = active_step(
        values, factor, remainder, seen, near_bounds(problem.unknowns), problem.unknowns, precision
    )
    promised = 0.5 * float(np.sum((factor @ step) ** 2))
    low, high = np.asarray([u.bounds for u in problem.unknowns], np.float64).T
    end = np.where(values - low < high - values, low, high)
    return np.where(held.bound, end - values, step), promised


def is_held(problem: Problem, here: Look) -> bool:
    """Does a bound or a sum hold some coefficient?"""
    values, factor, remainder, _ = here.linear()
    seen, near = np.linalg.norm(factor, axis=0) > 0, near_bounds(problem.unknowns)
    return active_step(values, factor, remainder, seen, near, problem.unknowns, 1e-9)[1].any


def shares(before: np.ndarray | None, step: np.ndarray) -> tuple[float, ...]:
    """How much of a step to try, in turn. Where steps follow one another in one direction, each a share of the one
    before, the sum of all that would follow (Aitken 1926).
    """
    if before is not None and (size := float(np.linalg.norm(before) * np.linalg.norm(step))):
        share = float(np.linalg.norm(step) / np.linalg.norm(before))
        if before @ step > STRAIGHT * size and share < 1:
            return min(1 / (1 - share), FURTHEST), 1.0, 0.25
    return 1.0, 0.25


def is_stuck(history: Sequence[FitStep], problem: Problem, best: Look) -> bool:
    """Has the loss hardly fallen for some steps while a bound holds some coefficient? There no unknown has a slope, and
    a Gauss-Newton step along the bound leads further.
    """
    if len(history) < SLOW or history[-SLOW].loss - history[-1].loss > HARDLY * history[-1].loss:
        return False
    return is_held(problem, best)
