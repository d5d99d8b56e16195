"""Scales: in what the unknown of a fit is linear.

    s = value              interval, unbounded
    s = log(value)         log
    s = log(value - 1)     log-excess

The one place that knows what the name of a scale means: bounds, intervals and tests of identifiability all ask it.
"""

from dataclasses import dataclass
from math import inf
from typing import Final, Literal

import jax
import jax.numpy as jnp
import numpy as np

ScaleName = Literal["interval", "log", "log-excess", "unbounded"]

LARGEST_EXPONENT = 700.0
"""exp of more is no number of 64 bits."""


@dataclass(frozen=True)
class Scale:
    """s = log(value - zero) where there is a zero, else the value itself."""

    zero: float | None = None

    def forward(self, value):
        """s of a value above `floor`; differentiable."""
        if self.zero is None:
            return value
        return (jnp if isinstance(value, jax.Array) else np).log(value - self.zero)

    def inverse(self, s):
        """The value at s; differentiable."""
        if self.zero is None:
            return s
        if isinstance(s, jax.Array):
            return jnp.exp(s) + self.zero
        return np.exp(np.minimum(s, LARGEST_EXPONENT)) + self.zero

    def slope(self, value):
        """ds/dvalue, by which a small error of the value becomes one of s."""
        return 1.0 if self.zero is None else 1 / (value - self.zero)

    def floor(self, lowest: float) -> float:
        """The least that the lower end of an interval can be, where the value may go down to `lowest`."""
        return lowest if self.zero is None else max(lowest, self.zero)

    @property
    def open(self) -> bool:
        """Does an interval on it lie above the floor, which s does not reach?"""
        return self.zero is not None


SCALES: Final[dict[str, Scale]] = {
    "interval": Scale(),
    "log": Scale(0.0),
    "log-excess": Scale(1.0),
    "unbounded": Scale(),
}
"""By the name in a row. "unbounded" says that the row itself has no bounds: a fit takes those that the scene
suggests.
"""


def typical_size(value: float, lowest: float, low: float, high: float) -> float:
    """What a step of an unknown between `low` and `high` is small against: its distance from its lowest value or,
    where there is none, a hundredth of its interval and its own size."""
    return abs(value - lowest) if lowest > -inf else max(abs(value), 0.01 * (high - low))
