"""What a fit hands back: plain records of Python and NumPy values, with nothing to compile.

A coefficient that the pictures do not determine has no standard error and no interval here; its
value is kept for the scene, and `remark` says in words why it is not to be relied on.
"""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from ._held_out import HeldOut

Status = Literal["converged", "misfit", "not_converged", "not_identifiable", "interrupted"]


def _join(names: tuple[str, ...]) -> str:
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
            parts.append(f"cannot be told apart from {_join(self.confounded_with)}")
        elif not self.identifiable and not self.at_bound:
            parts.append("the pictures do not determine it")
        if self.at_bound:
            parts.append(f"at its {self.bound_reached}")
        return "; ".join(parts)

    def to_json(self) -> dict[str, Any]:
        """The coefficient as a dictionary of JSON values; a number that is not finite becomes None."""
        interval = self.interval_95
        return {
            "symbol": self.symbol,
            "value": _finite(self.value),
            "start": _finite(self.start),
            "standard_error": None if self.standard_error is None else _finite(self.standard_error),
            "interval_95": None if interval is None else [_finite(end) for end in interval],
            "shift": _finite(self.shift),
            "identifiable": bool(self.identifiable),
            "seen": bool(self.seen),
            "confounded_with": list(self.confounded_with),
            "at_bound": bool(self.at_bound),
            "bounds": [_finite(end) for end in self.bounds],
            "unit": self.unit,
            "moves": self.moves,
            "remark": self.remark,
        }


@dataclass(frozen=True)
class FitStep:
    """One step of the solver: its number from 0, the loss after it (half the sum of squared weighted
    residuals), the seconds since the solve began, and whether the solver kept the step."""

    step: int
    loss: float
    seconds: float
    accepted: bool


@dataclass(frozen=True)
class FitStage:
    """A stretch of a fit that looked at the targets in one way.

    - `name`: that way, in words: "one pixel in 8", "all pixels".
    - `samples`: how many places in the targets each step looked at.
    - `steps`, `seconds`: what it took.
    """

    name: str
    samples: int
    steps: int
    seconds: float


@dataclass(frozen=True, eq=False)
class FitView:
    """One camera's pictures, linear Rec. 709 RGB.

    `target`, `render` and `residual` (`render - target`, 0 where `weight` is 0) are `(H, W, 3)`;
    `weight` is `(H, W)` in [0, 1], the mask. Raises `ValueError` where the shapes disagree.
    """

    camera: str
    target: np.ndarray = field(repr=False)
    render: np.ndarray = field(repr=False)
    residual: np.ndarray = field(repr=False)
    weight: np.ndarray = field(repr=False)

    def __post_init__(self) -> None:
        picture = (*np.shape(self.weight), 3)
        for name in ("target", "render", "residual"):
            if np.shape(getattr(self, name)) != picture:
                raise ValueError(
                    f"view {self.camera!r}: {name} has shape {np.shape(getattr(self, name))}, but the "
                    f"weight is {np.shape(self.weight)}, so {picture} is needed"
                )

    @property
    def rmse(self) -> float:
        """Root mean square of the residual over the channels of the pixels with weight above 0; 0 if none."""
        inside = np.asarray(self.residual, np.float64)[np.asarray(self.weight) > 0]
        return float(np.sqrt(np.mean(inside**2))) if inside.size else 0.0


@dataclass(frozen=True, eq=False)
class FitResult:
    """The outcome of a fit.

    - `status`: `"converged"` (and every coefficient is determined), `"misfit"` (it came to rest, but the model is wrong
      by more than the intervals can carry), `"not_converged"`, `"not_identifiable"` or `"interrupted"`;
      `message` says the same in a sentence.
    - `coefficients`: one `FittedCoefficient` per fitted number, p in all.
    - `correlation`: `(p, p)`, in the order of `coefficients`; NaN where it is not defined.
    - `rank`: of the Jacobian at the solution, p if everything is determined.
    - `rmse`, `noise`: linear RGB; `noise_given` is False when the noise was estimated from the residual; NaN
      where it could not be.
    - `misfit`: the residual is not noise (neighbouring pixels agree, or it is well above the given noise), and what
      that does to a coefficient is many times what noise would do; `at_rounding_level`: it is no more than
      arithmetic and solver leave over.
    - `sampling`: "points" (one in the middle of each pixel) or "pixel" (the target averages over the area of each).
    - `causes`: of a misfit, the likely mistakes and the share of the residual (RMS) that each would remove.
    - `steps`, `history`: how many steps the solver took, and one `FitStep` for each; `stages`: one `FitStage` for
      each way in which it looked at the targets, from coarse to fine.
    - `seconds_compile`, `seconds_solve`: wall-clock seconds.
    - `starts_tried`: how many starting points were solved from; the best is reported.
    - `effects`: `(name, on, why)` for each effect of the renderer.
    - `held_out`: how well what was left out is predicted; None where nothing was.
    - `views`: one `FitView` per camera; `scene`: the fitted scene; `free`: the free names as asked for.

    Raises `ValueError` for an unknown status or a correlation of another shape.
    """

    status: Status
    message: str
    coefficients: tuple[FittedCoefficient, ...]
    correlation: np.ndarray = field(repr=False)
    rank: int
    rmse: float
    noise: float
    noise_given: bool
    steps: int
    history: tuple[FitStep, ...] = field(repr=False)
    seconds_compile: float
    seconds_solve: float
    starts_tried: int
    effects: tuple[tuple[str, bool, str], ...] = field(repr=False)
    views: tuple[FitView, ...]
    scene: Any = field(repr=False)
    free: tuple[str, ...]
    misfit: bool = False
    at_rounding_level: bool = False
    stages: tuple[FitStage, ...] = ()
    sampling: str = "points"
    causes: tuple[tuple[str, float], ...] = ()
    held_out: HeldOut | None = None

    def __post_init__(self) -> None:
        if self.status not in get_args(Status):
            raise ValueError(f"status is {self.status!r}; one of {', '.join(get_args(Status))} is needed")
        count = len(self.coefficients)
        if np.shape(self.correlation) != (count, count):
            raise ValueError(
                f"correlation has shape {np.shape(self.correlation)}, but there are {count} "
                f"coefficients, so ({count}, {count}) is needed"
            )

    @property
    def exit_code(self) -> int:
        """0 for a converged fit, 1 for any other outcome."""
        return 0 if self.status == "converged" else 1

    def __getitem__(self, name: str) -> FittedCoefficient:
        """The coefficient of that name. Raises `KeyError` with the nearest names."""
        names = [coefficient.name for coefficient in self.coefficients]
        name = name if name in names else name.removeprefix("material.")
        if name in names:
            return self.coefficients[names.index(name)]
        near = [known for known in names if known.startswith(f"{name}.")]
        near = near or difflib.get_close_matches(name, names, n=1, cutoff=0.0)
        hint = f"did you mean {' or '.join(near)}?" if near else "no coefficient was fitted"
        raise KeyError(f"no fitted coefficient is named {name!r}; {hint}")

    def to_json(self) -> dict[str, Any]:
        """The result without its pictures, as strictly valid JSON values: what is not finite becomes None."""
        return {
            "status": self.status,
            "message": self.message,
            "free": list(self.free),
            "coefficients": {coefficient.name: coefficient.to_json() for coefficient in self.coefficients},
            "correlation": [[_finite(entry) for entry in row] for row in np.asarray(self.correlation)],
            "rank": int(self.rank),
            "rmse": _finite(self.rmse),
            "noise": _finite(self.noise),
            "noise_given": bool(self.noise_given),
            "misfit": bool(self.misfit),
            "at_rounding_level": bool(self.at_rounding_level),
            "sampling": self.sampling,
            "causes": [{"what": what, "removed": _finite(removed)} for what, removed in self.causes],
            "held_out": None if self.held_out is None else self.held_out.to_json(),
            "steps": int(self.steps),
            "starts_tried": int(self.starts_tried),
            "seconds": {"compile": _finite(self.seconds_compile), "solve": _finite(self.seconds_solve)},
            "effects": [{"name": name, "on": bool(on), "why": why} for name, on, why in self.effects],
            "views": [
                {"camera": view.camera, "rmse": _finite(view.rmse), "pixels": int(np.sum(view.weight > 0))}
                for view in self.views
            ],
            "stages": [
                {"name": s.name, "samples": int(s.samples), "steps": int(s.steps), "seconds": _finite(s.seconds)}
                for s in self.stages
            ],
            "history": [
                {
                    "step": int(s.step),
                    "loss": _finite(s.loss),
                    "seconds": _finite(s.seconds),
                    "accepted": bool(s.accepted),
                }
                for s in self.history
            ],
        }


def _finite(number: float) -> float | None:
    """The number as a Python float, or None where JSON has no token for it."""
    return float(number) if math.isfinite(number) else None
