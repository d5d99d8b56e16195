"""From the end of a solve to the result: did it converge, what is determined, and how well."""

import dataclasses
from collections import Counter

import numpy as np

from diffwhitted.scene import Scene

from ._judged import Judged, judged
from ._result import FitResult, FittedCoefficient, Status
from .judging._causes import Cause
from .judging._identifiability import Uncertainty
from .problem._target import CheckedTarget, residual_count
from .problem._unknowns import Unknown, free_as_named, insert
from .solving._settling import Settled
from .solving._solve import Solution

MISFIT = (
    "the model does not fit: what is left over is no noise, so something that is fixed is wrong or the model lacks it"
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
    best, unknowns, residuals = end.solution, end.problem.unknowns, residual_count(targets)
    found = judged(scene, targets, end)
    notes = (*found.notes, *notes)
    if np.isnan(found.noise):
        notes = (
            f"there are no more residuals ({residuals}) than unknowns ({len(unknowns)}), so the noise cannot be "
            "estimated and there are no standard errors; give the noise",
            *notes,
        )
    status, message = _status(best, found, unknowns)
    squares = sum(float(np.sum(v.residual.astype(np.float64)[v.weight > 0] ** 2)) for v in found.views)
    return FitResult(
        status=status,
        message="; ".join((message, *notes)),
        coefficients=tuple(_coefficient(i, u, found, best, start, unknowns) for i, u in enumerate(unknowns)),
        correlation=found.known.correlation,
        rank=found.known.rank,
        rmse=float(np.sqrt(squares / sum(3 * int((t.mask > 0).sum()) for t in targets))),
        noise=found.noise,
        noise_given=targets[0].noise is not None,
        steps=len(best.history),
        history=best.history,
        seconds_compile=0.0,
        seconds_solve=0.0,
        starts_tried=1,
        effects=effects,
        views=found.views,
        scene=insert(scene, unknowns, found.values.astype(scene.dtype)),
        free=free_as_named(scene, unknowns),
        misfit=found.misfit,
        at_rounding_level=found.at_rounding,
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


def with_causes(result: FitResult, found: tuple[Cause, ...]) -> FitResult:
    """The result of a misfit with what may be wrong."""
    head, _, rest = result.message.partition("; ")
    if found:
        said = "most likely " + "; or ".join(
            f"{cause.what}, which would remove {cause.removed:.0%} of what is left over" for cause in found[:3]
        )
    else:
        said = (
            "none of the usual mistakes explains it (curve, exposure, flip or shift of the picture, a few wild pixels, "
            "kind of highlight and of shadows)"
        )
    message = "; ".join(part for part in (f"{head}: {said}", rest) if part)
    return dataclasses.replace(result, message=message, causes=tuple((c.what, c.removed) for c in found))


def _coefficient(i: int, unknown: Unknown, found: Judged, best: Solution, start, unknowns) -> FittedCoefficient:
    known: Uncertainty = found.known
    sure, determined = bool(known.identifiable[i]), np.isfinite(known.standard_error[i])
    at_bound = bool(found.at_bound[i])
    return FittedCoefficient(
        name=unknown.name,
        symbol=unknown.row.symbol,
        value=float(found.values[i]),
        start=float(start[i]),
        standard_error=float(known.standard_error[i]) if determined else None,
        interval_95=_interval(known.interval[i], unknown, at_bound) if determined else None,
        shift=float(best.shift[i]),
        identifiable=sure,
        seen=bool(known.seen[i]),
        confounded_with=tuple(unknowns[j].name for j in known.confounded[i]),
        at_bound=at_bound,
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


def _status(best: Solution, found: Judged, unknowns) -> tuple[Status, str]:
    if best.interrupted:
        return "interrupted", f"stopped on request after {len(best.history)} steps; this is the best so far"
    if found.moving:
        return "not_converged", (
            f"not converged after {len(best.history)} steps: {', '.join(found.moving)} still moving; "
            "give more steps, another start, or several starts"
        )
    lost = [u.name for u, sure in zip(unknowns, found.known.identifiable, strict=True) if not sure]
    if lost:
        return (
            "not_identifiable",
            f"the pictures do not determine {', '.join(lost)}; fix them, or add a view that shows them",
        )
    if found.misfit:
        return "misfit", f"at rest after {len(best.history)} steps, but {MISFIT}"
    return "converged", f"converged in {len(best.history)} steps"
