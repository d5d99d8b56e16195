"""What a fit hands back: plain records of Python and NumPy values, with nothing to compile.

A coefficient that the pictures do not determine has no standard error and no interval here; its
value is kept for the scene, and `remark` says in words why it is not to be relied on.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from ._coefficients import FittedCoefficient, WildPixel, finite
from ._held_out import HeldOut

Status = Literal["converged", "misfit", "not_converged", "not_identifiable", "interrupted"]


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
    - `rank`: of the Jacobian at the solution, the number of unknowns if everything is determined.
    - `rmse`, `noise`: linear RGB; `noise_given` is False when the noise was estimated from the residual; NaN
      where it could not be.
    - `misfit`: the residual is not noise (neighbouring pixels agree, or it is well above the given noise), and what
      that does to a coefficient is many times what noise would do; `at_rounding_level`: it is no more than
      arithmetic and solver leave over.
    - `sampling`: "points" (one in the middle of each pixel) or "pixel" (the target averages over the area of each).
    - `wild`: a `WildPixel` for each that is further off than what the others show allows, the worst first.
    - `loss`: how much large residuals counted.
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
    wild: tuple[WildPixel, ...] = ()
    loss: str = "square"
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
            "correlation": [[finite(entry) for entry in row] for row in np.asarray(self.correlation)],
            "rank": int(self.rank),
            "rmse": finite(self.rmse),
            "noise": finite(self.noise),
            "noise_given": bool(self.noise_given),
            "misfit": bool(self.misfit),
            "at_rounding_level": bool(self.at_rounding_level),
            "sampling": self.sampling,
            "loss": self.loss,
            "wild": [pixel.to_json() for pixel in self.wild],
            "causes": [{"what": what, "removed": finite(removed)} for what, removed in self.causes],
            "held_out": None if self.held_out is None else self.held_out.to_json(),
            "steps": int(self.steps),
            "starts_tried": int(self.starts_tried),
            "seconds": {"compile": finite(self.seconds_compile), "solve": finite(self.seconds_solve)},
            "effects": [{"name": name, "on": bool(on), "why": why} for name, on, why in self.effects],
            "views": [
                {"camera": view.camera, "rmse": finite(view.rmse), "pixels": int(np.sum(view.weight > 0))}
                for view in self.views
            ],
            "stages": [
                {"name": s.name, "samples": int(s.samples), "steps": int(s.steps), "seconds": finite(s.seconds)}
                for s in self.stages
            ],
            "history": [
                {
                    "step": int(s.step),
                    "loss": finite(s.loss),
                    "seconds": finite(s.seconds),
                    "accepted": bool(s.accepted),
                }
                for s in self.history
            ],
        }
