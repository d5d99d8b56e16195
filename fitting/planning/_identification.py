"""What a fit would know: plain numbers by the names of the unknowns."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._result import FittedCoefficient

STRONG = 0.9
"""Correlations that are worth a word."""


@dataclass(frozen=True, eq=False)
class Identification:
    """What a fit of pictures that are not yet taken would know.

    - `coefficients`: one `FittedCoefficient` per free number: the value of the scene, and the standard error and 95 %
      interval that a fit would have there.
    - `correlation`: (p, p), in their order; `rank`: of the Jacobian, p if everything is determined.
    - `views`: the names of the pictures; `pixels`: how many of their pixels count; `noise`: the standard deviation of a
      pixel value that is as good as theirs.
    - `notes`: what was left as it is, in words.
    """

    coefficients: tuple[FittedCoefficient, ...]
    correlation: np.ndarray = field(repr=False)
    rank: int
    views: tuple[str, ...]
    pixels: int
    noise: float
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> FittedCoefficient:
        """The coefficient of that name. Raises `KeyError` with the nearest name."""
        names = [c.name for c in self.coefficients]
        if name in names:
            return self.coefficients[names.index(name)]
        near = difflib.get_close_matches(name, names, n=1, cutoff=0.0)
        raise KeyError(f"no free coefficient is named {name!r}; did you mean {near[0]}?")

    @property
    def identifiable(self) -> bool:
        """Would the pictures determine every coefficient?"""
        return all(c.identifiable for c in self.coefficients)

    @property
    def strongest(self) -> tuple[tuple[str, str, float], ...]:
        """The pairs of coefficients that are correlated by 0.9 or more, the strongest first."""
        found, count = [], len(self.coefficients)
        for i in range(count):
            for j in range(i):
                value = float(self.correlation[i, j])
                if math.isfinite(value) and abs(value) >= STRONG:
                    found.append((self.coefficients[j].name, self.coefficients[i].name, value))
        return tuple(sorted(found, key=lambda pair: -abs(pair[2])))

    def to_json(self) -> dict[str, Any]:
        """As strictly valid JSON values; a number that is not finite becomes None."""
        return {
            "identifiable": self.identifiable,
            "rank": self.rank,
            "coefficients": {c.name: c.to_json() for c in self.coefficients},
            "correlation": [
                [float(x) if math.isfinite(x) else None for x in row] for row in np.asarray(self.correlation)
            ],
            "views": list(self.views),
            "pixels": self.pixels,
            "noise": self.noise,
            "notes": list(self.notes),
        }
