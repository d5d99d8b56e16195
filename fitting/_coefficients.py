"""What a fit says of one number, and of one pixel that is no measurement."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any


def join(names: tuple[str, ...]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


@dataclass(frozen=True)
class FittedCoefficient:
    """One fitted number: a scalar coefficient, or one channel of a coloured one.

    - `name`: `"glass.k_d"`, or `"floor.k_d.r"`, `".g"`, `".b"` for a channel.
    - `symbol`: as in the equations, `"k_d"`.
    - `value`, `start`: at the solution and before the first step, in `unit`.
    - `standard_error`, `interval_95`: in `unit`; None unless `identifiable`.
    - `identifiable`: the pictures determine it.
    - `seen`: some pixel depends on it.
    - `confounded_with`: names of the coefficients it cannot be told apart from.
    - `shift`: how far the value moved when 2 x 2 filtered trees took the place of each, in `unit`: what the trees leave
      out of the picture, and part of the standard error and the interval. 0 where no ray moves.
    - `moves`: what a change of it moves in the picture: "nothing", "patterns", "shadows" or "rays".
    - `prior`: mean and standard deviation of what was known of it before, None: nothing.
    - `tied_to`: the coefficient that it is a fixed multiple of, if that was asked.
    - `further`: further remarks, such as on a sum that has reached its limit.
    - `at_bound`: the solution lies on one of the `bounds` (lowest and highest value allowed).

    Raises `ValueError` for a standard error or an interval on a coefficient that is not identifiable.
    """

    name: str
    symbol: str
    value: float
    start: float
    standard_error: float | None
    interval_95: tuple[float, float] | None
    identifiable: bool
    seen: bool
    confounded_with: tuple[str, ...]
    at_bound: bool
    bounds: tuple[float, float]
    unit: str
    shift: float = 0.0
    moves: str = "nothing"
    prior: tuple[float, float] | None = None
    tied_to: str = ""
    further: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.identifiable and not (self.standard_error is None and self.interval_95 is None):
            raise ValueError(
                f"{self.name}: a coefficient that is not identifiable has no standard error and no "
                f"interval, but got {self.standard_error} and {self.interval_95}; pass None for both"
            )

    @property
    def bound_reached(self) -> str:
        """`"lower bound 0"` or `"upper bound 1"` where `at_bound`, otherwise an empty string."""
        if not self.at_bound:
            return ""
        lower, upper = self.bounds
        nearer_lower = abs(self.value - lower) <= abs(self.value - upper)
        return f"lower bound {lower:.6g}" if nearer_lower else f"upper bound {upper:.6g}"

    @property
    def remark(self) -> str:
        """In plain words, what keeps this number from being taken as it stands; empty if nothing."""
        parts = []
        if not self.seen:
            parts.append("no pixel depends on it")
        elif self.confounded_with:
            parts.append(f"cannot be told apart from {join(self.confounded_with)}")
        elif not self.identifiable and not self.at_bound:
            parts.append("the pictures do not determine it")
        if self.at_bound:
            parts.append(f"at its {self.bound_reached}")
        if self.prior is not None:
            parts.append(f"prior {self.prior[0]:g} ± {self.prior[1]:g}, {self.sigmas_from_prior:+.1f} sigma from it")
        return "; ".join((*parts, *self.further))

    @property
    def sigmas_from_prior(self) -> float:
        """How many standard deviations of its prior the value lies above the prior's mean; NaN without a prior."""
        return math.nan if self.prior is None else (self.value - self.prior[0]) / self.prior[1]

    def to_json(self) -> dict[str, Any]:
        """The coefficient as a dictionary of JSON values; a number that is not finite becomes None."""
        interval = self.interval_95
        return {
            "symbol": self.symbol,
            "value": finite(self.value),
            "start": finite(self.start),
            "standard_error": None if self.standard_error is None else finite(self.standard_error),
            "interval_95": None if interval is None else [finite(end) for end in interval],
            "shift": finite(self.shift),
            "identifiable": bool(self.identifiable),
            "seen": bool(self.seen),
            "confounded_with": list(self.confounded_with),
            "at_bound": bool(self.at_bound),
            "bounds": [finite(end) for end in self.bounds],
            "unit": self.unit,
            "moves": self.moves,
            "prior": self.prior
            and {"mean": self.prior[0], "standard_deviation": self.prior[1], "sigmas_off": self.sigmas_from_prior},
            "tied_to": self.tied_to or None,
            "remark": self.remark,
        }


@dataclass(frozen=True)
class WildPixel:
    """A pixel that is further off than what the others show allows.

    - `target`: its name; `row`, `column`: from 0, row 0 on top.
    - `residual`: render - target of its worst channel, linear RGB.
    - `deviations`: how many robust standard deviations of the others that is, beyond what the render varies by there.
    - `left_out`: the fit does not use it, since a few such pixels carried nearly all that was left over.
    """

    target: str
    row: int
    column: int
    residual: float
    deviations: float
    left_out: bool

    def to_json(self) -> dict[str, Any]:
        """The pixel as a dictionary of JSON values."""
        return {
            "target": self.target,
            "row": self.row,
            "column": self.column,
            "residual": finite(self.residual),
            "deviations": finite(self.deviations),
            "left_out": self.left_out,
        }


def finite(number: float) -> float | None:
    """The number as a Python float, or None where JSON has no token for it."""
    return float(number) if math.isfinite(number) else None
