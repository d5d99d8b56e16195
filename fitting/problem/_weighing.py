"""How much each residual of a fit counts: the standard deviation that it is divided by."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ._problem import Problem
from ._target import CheckedTarget
from ._views import reweighted

UNIT = 0.01
"""Unit of the residuals where no noise is given; it sets how bold the solver's first steps are."""


@dataclass(frozen=True)
class Weighing:
    """A standard deviation for each channel of each pixel of each target."""

    deviations: tuple[np.ndarray, ...]
    """(height, width, 3)."""
    total: float
    """Number of residuals."""
    estimated: bool = False
    """The deviations are what the residual showed, not given or a mere unit."""
    slack: float = 1.0
    """Standard errors are so many times what these weights say, since large residuals weigh less."""
    robust: bool = False
    """The weights are those of a robust loss that was asked for."""

    @property
    def unit(self) -> float:
        """The least of them."""
        return float(min(deviation.min() for deviation in self.deviations))

    def typical(self, targets: Sequence[CheckedTarget]) -> float:
        """The deviation that, if all pixels that count had it, would tell as much."""
        used = [d[t.mask > 0].ravel() for d, t in zip(self.deviations, targets, strict=True)]
        return float(np.mean(np.concatenate(used) ** -2.0) ** -0.5)

    def weights(self, targets: Sequence[CheckedTarget]) -> list[np.ndarray]:
        """What residuals are multiplied by, so that the sum of their squares is a mean; equal channels count as one."""
        return [
            np.sqrt(target.mask / (3 / target.channels))[..., None] / deviation / np.sqrt(self.total)
            for target, deviation in zip(targets, self.deviations, strict=True)
        ]


def first_weighing(targets: Sequence[CheckedTarget], total: float) -> Weighing:
    """The given noise, or a unit."""
    return Weighing(
        tuple(
            np.full(t.image.shape, UNIT) if t.noise is None else np.asarray(t.noise.deviation(t.image)) for t in targets
        ),
        total,
    )


def weighed(problem: Problem, targets: Sequence[CheckedTarget], weighing: Weighing) -> Problem:
    """The problem with these weights."""
    pairs = zip(problem.views, weighing.weights(targets), strict=True)
    return replace(problem, views=tuple(reweighted(view, weight) for view, weight in pairs))
