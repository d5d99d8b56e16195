"""What a few steps with another scene would leave, for the search of what is wrong."""

from collections.abc import Sequence

import numpy as np

from diffwhitted.scene import Scene

from .._errors import FitError
from ..judging._causes import Cause, causes
from ..problem._build import build
from ..problem._target import CheckedTarget
from ..problem._ties import tied
from ..problem._unknowns import Unknown, list_unknowns
from ..problem._weighing import weighed
from ._sampling import SIDE
from ._settling import Settled
from ._solve import solve

STEPS = 8
NARROWER = {"halfway": 4.0, "reflected": 0.25}
"""A highlight of this kind is as wide as one of the other with so many times its exponent."""


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
        problem, _ = build(other, targets, names, tied(mine, None), values, side, max_depth, footprint)
        problem = weighed(problem, targets, end.weighing)
        start = _with_exponents(mine, values, scene, other)
        return float(np.sqrt(2 * solve(problem, start, max_steps=STEPS).loss))

    return causes(scene, end.problem, targets, values, left_of)


def _with_exponents(unknowns: tuple[Unknown, ...], values: np.ndarray, scene: Scene, other: Scene) -> np.ndarray:
    """The values, with the exponents of highlights of another kind as wide as they were, within their bounds."""

    def factor(unknown: Unknown) -> float:
        if unknown.row.name != "phong_exponent":
            return 1.0
        before, now = (s.materials[unknown.parameter.owner].highlight for s in (scene, other))
        return 1.0 if before == now else NARROWER.get(now, 1.0)

    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    return np.clip(values * [factor(u) for u in unknowns], low, high)
