"""Points or pixels: is a target one sample a pixel, or an average over the area of each?

The residual tells. At any coefficients, edges leave far less behind where they are sampled as in the target; what the
next linear step would leave is compared, so that wrong coefficients do not hide it. Where no ray moves, n x n points
need no other program than one.
"""

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from diffwhitted.tree import sample_places

from ..problem._problem import Problem, factorise, prepared
from ..problem._views import at_places, some_passes

LOOKS = 2
"""So many samples along the side of a pixel are enough to find out."""
CLEARLY = 1.1
"""One is taken for better where the other leaves so many times more."""
SIDE = 4
"""Samples along the side of a pixel, of a target that averages over it."""


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


def sampled(problem: Problem, side: int, values: np.ndarray) -> Problem:
    """The problem with side x side points a pixel."""
    dtype = problem.scene.dtype
    views = tuple(at_places(view, sample_places(side, dtype)) for view in problem.views)
    views = prepared(problem.scene, problem.nameless, jnp.asarray(problem.all_values(values), dtype), views, False)
    return replace(problem, views=views)
