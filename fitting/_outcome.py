"""From the end of a solve to the result: did it converge, what is determined, and how well."""

import dataclasses
from collections import Counter

import jax.numpy as jnp
import numpy as np

from diffwhitted.image import gathered
from diffwhitted.scene import Scene

from ._identifiability import Uncertainty, uncertainty
from ._problem import Problem
from ._result import FitResult, FittedCoefficient, FitView
from ._solve import Solution
from ._target import Target
from ._unknowns import Unknown, insert

SETTLED = 1e-4
"""Converged: the next Gauss-Newton step is below this share of the coefficient, or a 20th of its standard error."""
ON_THE_BOUND = 1e-3
"""Share of the interval within which a coefficient counts as lying on its bound."""


def outcome(scene: Scene, targets: tuple[Target, ...], problem: Problem, start: np.ndarray, best: Solution, unit: float,
            effects: tuple[tuple[str, bool, str], ...], notes: tuple[str, ...]) -> FitResult:
    """The result of the best run, whose residuals are in `unit` where no noise is given; its counts of starts and seconds are filled in by the caller."""
    unknowns = problem.unknowns
    residuals = sum(3 * int((t.mask > 0).sum()) for t in targets)
    given = targets[0].noise is not None
    # The residuals in the factor are divided by the root of their number; so is their noise here.
    mean_square = 2 * best.loss
    eps = float(jnp.finfo(scene.dtype).eps)
    rounding = eps * max(float(np.abs(t.image).max()) for t in targets) / unit / np.sqrt(residuals)
    estimated = np.hypot(np.sqrt(mean_square / max(residuals - len(unknowns), 1)), rounding)
    noise = 1 / np.sqrt(residuals) if given else estimated
    precision = eps**0.7
    known = uncertainty(best.factor, noise, best.values, unknowns, precision)
    at_bound = _on_bound(best.values, unknowns)
    moving = _unsettled(best, known, unknowns, at_bound, precision)
    status, message = _status(best, known, moving, unknowns)
    views = tuple(_view(t, film, scene) for t, film in zip(targets, best.films, strict=True))
    squares = sum(float(np.sum(v.residual.astype(np.float64)[v.weight > 0] ** 2)) for v in views)
    spread = np.sqrt(np.mean([np.mean(t.noise**2) for t in targets])) if given else noise * np.sqrt(residuals) * unit
    return FitResult(
        status=status, message="; ".join((message, *notes)),
        coefficients=tuple(_coefficient(i, u, best, start, known, at_bound, unknowns) for i, u in enumerate(unknowns)),
        correlation=known.correlation, rank=known.rank, rmse=float(np.sqrt(squares / residuals)), noise=float(spread),
        noise_given=given, steps=len(best.history), history=best.history, seconds_compile=0.0, seconds_solve=0.0,
        starts_tried=1, effects=effects, views=views,
        scene=insert(scene, unknowns, best.values.astype(scene.dtype)),
        free=tuple(dict.fromkeys(u.coefficient for u in unknowns)),
    )


def with_runs(result: FitResult, solutions: list[Solution], compiling: float) -> FitResult:
    """The result with what all runs together took."""
    ends = Counter(f"{s.loss:.2g}" for s in solutions)
    note = f"; {len(solutions)} starts ended at {len(ends)} different losses" if len(solutions) > 1 else ""
    return dataclasses.replace(result, message=result.message + note, starts_tried=len(solutions), seconds_compile=compiling,
                               seconds_solve=sum(s.seconds_solve for s in solutions))


def _coefficient(i: int, unknown: Unknown, best: Solution, start, known: Uncertainty, at_bound, unknowns) -> FittedCoefficient:
    sure = bool(known.identifiable[i])
    return FittedCoefficient(
        name=unknown.name, symbol=unknown.row.symbol, value=float(best.values[i]), start=float(start[i]),
        standard_error=float(known.standard_error[i]) if sure else None,
        interval_95=_interval(known.interval[i], unknown, at_bound[i]) if sure else None,
        identifiable=sure, seen=bool(known.seen[i]), confounded_with=tuple(unknowns[j].name for j in known.confounded[i]),
        at_bound=bool(at_bound[i]), bounds=unknown.bounds, unit=unknown.row.unit,
    )


def _interval(ends: np.ndarray, unknown: Unknown, at_bound: bool) -> tuple[float, float]:
    """The 95 % interval; of a coefficient on its bound it reaches to that bound."""
    low, high = map(float, ends)
    if not at_bound:
        return low, high
    lowest, highest = unknown.bounds
    return (lowest, high) if low - lowest < highest - high else (low, highest)


def _on_bound(values: np.ndarray, unknowns: tuple[Unknown, ...]) -> np.ndarray:
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    share = (values - low) / (high - low)
    return (share < ON_THE_BOUND * np.where(low > 0, 0.01, 1)) | (share > 1 - ON_THE_BOUND)


def _unsettled(best: Solution, known: Uncertainty, unknowns, at_bound, precision: float) -> list[str]:
    """The coefficients that the next Gauss-Newton step would still move, leaving out those held by a bound."""
    size = np.linalg.norm(best.factor, axis=0)
    scale = np.where(size > 0, size, 1)
    step = -np.linalg.lstsq(best.factor / scale, best.remainder, rcond=precision)[0] / scale
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    allowed = SETTLED * np.maximum(abs(best.values), 0.01 * np.minimum(high - low, 1))
    allowed = np.fmax(allowed, 0.05 * known.standard_error)
    still = (abs(step) > allowed) & known.identifiable & ~at_bound
    return [u.name for u, moves in zip(unknowns, still, strict=True) if moves]


def _status(best: Solution, known: Uncertainty, moving: list[str], unknowns) -> tuple[str, str]:
    if best.interrupted:
        return "interrupted", f"stopped on request after {len(best.history)} steps; this is the best so far"
    if moving:
        return "not_converged", (f"not converged after {len(best.history)} steps: {', '.join(moving)} still moving; "
                                 "give more steps, another start, or several starts")
    lost = [u.name for u, sure in zip(unknowns, known.identifiable, strict=True) if not sure]
    if lost:
        return "not_identifiable", f"the pictures do not determine {', '.join(lost)}; fix them, or add a view that shows them"
    return "converged", f"converged in {len(best.history)} steps"


def _view(target: Target, film: np.ndarray, scene: Scene) -> FitView:
    camera = scene.cameras[target.camera]
    render = np.asarray(gathered(film, camera.height, camera.width))
    used = target.mask > 0
    residual = np.where(used[..., None], render - target.image, 0).astype(np.float32)
    return FitView(target.camera, target.image.astype(np.float32), render.astype(np.float32), residual, target.mask.astype(np.float32))
