"""How well a fit predicts what it did not look at: plain numbers, and what they mean in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

ALIKE = 1.2
"""Predicted as well as the others: the RMSE is no more times theirs."""


@dataclass(frozen=True)
class HeldOut:
    """What was left out of a fit, and how well the fitted scene predicts it.

    - `what`: in words: "shot left", "20 % of the pixels"; `pixels`: how many.
    - `rmse`: of the pixels left out, linear RGB; `rmse_fitted`: of those that the fit looked at.
    - `names`: of the targets that were left out as a whole.
    - `rounding`: what is left over of those left out is no more than arithmetic and solver leave.
    """

    what: str
    pixels: int
    rmse: float
    rmse_fitted: float
    rounding: bool = False
    names: tuple[str, ...] = ()

    @property
    def ratio(self) -> float:
        """RMSE of the pixels left out over that of the others; infinite where the others leave nothing over."""
        if self.rmse_fitted > 0:
            return self.rmse / self.rmse_fitted
        return math.inf if self.rmse > 0 else 1.0

    @property
    def sentence(self) -> str:
        """In words, with both numbers."""
        numbers = f"RMSE {self.rmse:.3g} left out, {self.rmse_fitted:.3g} fitted ({self.what})"
        if self.rounding or self.ratio <= ALIKE:
            return f"the pixels left out are predicted as well as the others: {numbers}"
        times = "a thousand times or more" if self.ratio >= 1000 else f"{self.ratio:.2g} times"
        return (
            f"the pixels left out are predicted {times} worse than the others: {numbers}; what is free follows its "
            "own pixels too closely, or the model lacks what the others show"
        )

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        ratio = self.ratio
        return {
            "what": self.what,
            "pixels": self.pixels,
            "rmse": self.rmse,
            "rmse_fitted": self.rmse_fitted,
            "ratio": ratio if math.isfinite(ratio) else None,
            "sentence": self.sentence,
        }
