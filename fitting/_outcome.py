"""From the end of a solve to the result: did it converge, what is determined, and how well."""

import dataclasses
from collections import Counter

import jax.numpy as jnp
import numpy as np

from diffwhitted.image import gathered
from diffwhitted.scene import Scene

from ._result import FitResult, FittedCoefficient, FitView, Status
from .judging._constrained import uncertainty_within
from .judging._evidence import evidence, narrowed, robust_errors
from .judging._identifiability import QUANTILE, Uncertainty
from .judging._misfit import at_rounding_level, is_structured
from .judging._rest import jacobian_precision, on_bound, residual_count, residual_noise, rest_share, unsettled
from .problem._target import CheckedTarget
from .problem._unknowns import Unknown, free_as_named, insert
from .solving._settling import Settled
from .solving._solve import Solution

SETTLED = 1e-4
"""Converged: the next Gauss-Newton step is below this share of the coefficient, or a 20th of its standard error."""
RESOLVED = 4.0
"""No standard error is below so many units in the last place of the coefficient."""
MOSTLY = 0.8
"""Share of a standard error from which on one cause is its main cause."""
MISFIT = (
    "the residual is not noise: something that is fixed is wrong or the model lacks it; the intervals are too narrow"
)


def outcome(
    scene: Scene,
    targets: tuple[CheckedTarget, ...],
    end: Settled,
    start: np.ndarray,
    effects: tuple[tuple[str, bool, str], ...],
    notes: tuple[str, ...],
) -> FitResult:
    """The result of the best run; its counts of starts and seconds are filled in by the caller."""
    best, unknowns, unit = end.solution, end.problem.unknowns, end.weighing.unit
    residuals = residual_count(targets)
    given, weighing = targets[0].noise is not None, end.weighing
    noises = weighing.deviations if given or weighing.estimated else (None,) * len(targets)
    noise = residual_noise(targets, best.loss, len(unknowns), unit, scene)
    eps = float(jnp.finfo(scene.dtype).eps)
    at_bound = on_bound(best.values, unknowns)
    views = tuple(_view(t, film, scene) for t, film in zip(targets, best.films, strict=True))
    rounding = at_rounding_level(views, eps, rest_share(scene))
    structured = not rounding and is_structured(views, noises, len(unknowns))
    found = None
    if not rounding and (structured or weighing.estimated):
        found = evidence(end.problem, targets, best.values, noise)

    def widen(ways: np.ndarray) -> np.ndarray:
        told = end.problem.prior_errors(ways, best.factor, noise, jacobian_precision(scene))
        robust = {} if found is None else robust_errors(narrowed(found, ways), structured)
        return np.max([told, *(weighing.slack * error for error in robust.values())], axis=0)

    known, held = uncertainty_within(
        best.factor, best.remainder, noise, best.values, unknowns, jacobian_precision(scene), RESOLVED * eps,
        best.shift, widen,
    )  # fmt: skip
    moving = unsettled(
        best.values, best.factor, best.remainder, known, unknowns, jacobian_precision(scene), SETTLED, 0.05
    )
    misfit = structured
    if misfit:
        notes = (MISFIT, *notes)
    coarse = [
        u.name
        for u, error, shift in zip(unknowns, known.standard_error, best.shift, strict=True)
        if shift > MOSTLY * QUANTILE * error
    ]
    if coarse:
        which = ", ".join(coarse) if len(coarse) < 4 else f"{len(coarse)} coefficients"
        notes = (
            f"the uncertainty of {which} is mostly what the ray trees leave out of a pixel; a larger footprint "
            "narrows it",
            *notes,
        )
    if said := end.said:
        notes = (said, *notes)
    if np.isnan(noise):
        notes = (
            f"there are no more residuals ({residuals}) than unknowns ({len(unknowns)}), so the noise cannot be "
            "estimated and there are no standard errors; give the noise",
            *notes,
        )
    status, message = _status(
        best, known, [u.name for u, moves in zip(unknowns, moving, strict=True) if moves], unknowns
    )
    squares = sum(float(np.sum(v.residual.astype(np.float64)[v.weight > 0] ** 2)) for v in views)
    spread = noise * np.sqrt(residuals) * weighing.typical(targets)
    return FitResult(
        status=status,
        message="; ".join((message, *notes)),
        coefficients=tuple(_coefficient(i, u, best, start, known, at_bound, unknowns) for i, u in enumerate(unknowns)),
        correlation=known.correlation,
        rank=known.rank,
        rmse=float(np.sqrt(squares / residuals)),
        noise=float(spread),
        noise_given=given,
        steps=len(best.history),
        history=best.history,
        seconds_compile=0.0,
        seconds_solve=0.0,
        starts_tried=1,
        effects=effects,
        views=views,
        scene=insert(scene, unknowns, best.values.astype(scene.dtype)),
        free=free_as_named(scene, unknowns),
        misfit=misfit,
        at_rounding_level=rounding,
        stages=best.stages,
        sampling=end.sampling,
    )


def with_runs(result: FitResult, solutions: list[Solution], compiling: float) -> FitResult:
    """The result with what all runs together took."""
    ends = Counter(f"{s.loss:.2g}" for s in solutions)
    note = f"; {len(solutions)} starts ended at {len(ends)} different losses" if len(solutions) > 1 else ""
    return dataclasses.replace(
        result,
        message=result.message + note,
        starts_tried=len(solutions),
        seconds_compile=compiling,
        seconds_solve=sum(s.seconds for s in solutions),
    )


def _coefficient(
    i: int, unknown: Unknown, best: Solution, start, known: Uncertainty, at_bound, unknowns
) -> FittedCoefficient:
    sure, determined = bool(known.identifiable[i]), np.isfinite(known.standard_error[i])
    return FittedCoefficient(
        name=unknown.name,
        symbol=unknown.row.symbol,
        value=float(best.values[i]),
        start=float(start[i]),
        standard_error=float(known.standard_error[i]) if determined else None,
        interval_95=_interval(known.interval[i], unknown, bool(at_bound[i])) if determined else None,
        shift=float(best.shift[i]),
        identifiable=sure,
        seen=bool(known.seen[i]),
        confounded_with=tuple(unknowns[j].name for j in known.confounded[i]),
        at_bound=bool(at_bound[i]),
        bounds=unknown.bounds,
        unit=unknown.unit,
        moves=unknown.row.moves,
    )


def _interval(ends: np.ndarray, unknown: Unknown, at_bound: bool) -> tuple[float, float]:
    """The 95 % interval; of a coefficient on its bound it reaches to that bound."""
    low, high = map(float, ends)
    if not at_bound:
        return low, high
    lowest, highest = unknown.bounds
    return (lowest, high) if low - lowest < highest - high else (low, highest)


def _status(best: Solution, known: Uncertainty, moving: list[str], unknowns) -> tuple[Status, str]:
    if best.interrupted:
        return "interrupted", f"stopped on request after {len(best.history)} steps; this is the best so far"
    if moving:
        return "not_converged", (
            f"not converged after {len(best.history)} steps: {', '.join(moving)} still moving; "
            "give more steps, another start, or several starts"
        )
    lost = [u.name for u, sure in zip(unknowns, known.identifiable, strict=True) if not sure]
    if lost:
        return (
            "not_identifiable",
            f"the pictures do not determine {', '.join(lost)}; fix them, or add a view that shows them",
        )
    return "converged", f"converged in {len(best.history)} steps"


def _view(target: CheckedTarget, film: np.ndarray, scene: Scene) -> FitView:
    camera = scene.cameras[target.camera]
    render = np.asarray(gathered(film, camera.height, camera.width))
    used = target.mask > 0
    residual = np.where(used[..., None], render - target.image, 0).astype(np.float32)
    return FitView(
        target.name,
        target.image.astype(np.float32),
        render.astype(np.float32),
        residual,
        target.mask.astype(np.float32),
    )
