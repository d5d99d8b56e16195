"""What a few steps with another scene would leave, for the search of what is wrong."""

from collections.abc import Sequence

import numpy as np

from diffwhitted.scene import Scene

from .._errors import FitError
from ..judging._causes import Cause, causes
from ..problem._build import build
from ..problem._target import CheckedTarget
from ..problem._unknowns import Unknown, list_unknowns
from ..problem._weighing import weighed
from ._sampling import SIDE
from ._settling import Settled
from ._solve import solve

STEPS = 12
NARROWER = (1.0, 4.0, 0.25)
"""A highlight of the other kind is as wide with about four times, or a fourth of, the exponent."""


def likely_causes(
    scene: Scene,
    targets: tuple[CheckedTarget, ...],
    names: Sequence[str],
    end: Settled,
    values: np.ndarray,
    max_depth: int | None,
    footprint: int,
) -> tuple[Cause, ...]:
    """What may be wrong with a fit that ended as a misfit; with scenes that move no ray also mistakes in the scene."""
    unknowns = end.problem.unknowns

    def left_of(other: Scene) -> float | None:
        if other is scene:
            return float(np.sqrt(2 * end.solution.loss))
        if end.problem.moves:
            return None
        try:
            mine = list_unknowns(other, names, {u.name: u.bounds for u in unknowns})
        except FitError:
            return None
        side = SIDE if end.sampling == "pixel" else 1
        problem, _ = build(other, targets, names, mine, values, side, max_depth, footprint)
        problem = weighed(problem, targets, end.weighing)
        starts = [_with_exponents(mine, values, factor) for factor in NARROWER]
        return min(float(np.sqrt(2 * solve(problem, start, max_steps=STEPS).loss)) for start in starts)

    return causes(scene, end.problem, targets, values, left_of)


def _with_exponents(unknowns: tuple[Unknown, ...], values: np.ndarray, factor: float) -> np.ndarray:
    """The values with the exponents times a factor, within their bounds."""
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    factors = [factor if u.row.name == "phong_exponent" else 1.0 for u in unknowns]
    return np.clip(values * factors, low, high)
