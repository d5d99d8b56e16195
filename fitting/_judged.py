"""What a solution is worth: standard errors, whether the model fits, and what must be said about it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import jax.numpy as jnp
import numpy as np

from diffwhitted.image import gathered
from diffwhitted.scene import Scene

from ._result import FitView
from .judging._active import Held, gauss_newton
from .judging._constrained import uncertainty_within
from .judging._evidence import evidence, narrowed, robust_errors, scatter
from .judging._faint import faint_highlights, said_of, with_faint
from .judging._identifiability import QUANTILE, Uncertainty, uncertainty
from .judging._misfit import agree_more_than, at_rounding_level, is_structured, neighbours_agree, times_the_noise
from .judging._rest import jacobian_precision, on_bound, residual_noise, rest_share, unsettled
from .problem._problem import Problem, factorise
from .problem._target import CheckedTarget, residual_count
from .solving._by_codes import by_codes
from .solving._settling import Settled
from .solving._solve import Solution

SETTLED = 1e-4
"""Converged: the next Gauss-Newton step is below this share of the coefficient, or a 20th of its standard error."""
RESOLVED = 4.0
"""No standard error is below so many units in the last place of the coefficient."""
MOSTLY = 0.8
"""Share of a standard error from which on one cause is its main cause."""
SERIOUS = 6.0
"""The model is wrong where an error that allows for it is so many times that of independent noise, and"""
BY_BOUNDS = 0.3
"""Share of the squares left over that a step without bounds would take away, from which on the bounds are the cause."""
VISIBLE = 1e-3
"""what is left over, weighed as in the fit, is more than this share of the picture, or"""
VISIBLE_OF_TREES = 0.02
"""than this one, where each pixel is a filtered tree, which knows edges only nearly."""


@dataclass
class Judged:
    """A solution, judged."""

    values: np.ndarray
    films: tuple[np.ndarray, ...]
    known: Uncertainty
    at_bound: np.ndarray
    moving: list[str]
    """Which coefficients are not at rest."""
    noise: float
    """Standard deviation of the pixels, linear."""
    residual: float
    """That of the residuals, weighed."""
    views: tuple[FitView, ...]
    at_rounding: bool
    misfit: bool
    notes: list[str] = field(default_factory=list)


def judged(scene: Scene, targets: Sequence[CheckedTarget], end: Settled) -> Judged:
    """The end of a fit, judged; where pictures are of whole numbers, by their codes."""
    found, unknowns = _as_it_ended(scene, targets, end), end.problem.unknowns
    faint = faint_highlights(unknowns, found.values, found.known)
    if not faint or end.solution.interrupted:
        return found
    # What no pixel shows need not be at rest.
    unseen = {unknowns[k].name for highlight in faint for k in (highlight.exponent, *highlight.shares)}
    return replace(
        found,
        known=with_faint(found.known, faint, end.problem, found.values, found.residual),
        moving=[name for name in found.moving if name not in unseen],
        notes=[said_of(faint, unknowns), *found.notes],
    )


def _as_it_ended(scene: Scene, targets: Sequence[CheckedTarget], end: Settled) -> Judged:
    best, unknowns, weighing = end.solution, end.problem.unknowns, end.weighing
    given, eps, precision = targets[0].noise is not None, float(jnp.finfo(scene.dtype).eps), jacobian_precision(scene)
    noises = weighing.deviations if given or weighing.estimated else (None,) * len(targets)
    noise = residual_noise(targets, best.loss, len(unknowns), weighing.unit, scene)
    views = views_of(targets, best.films)
    rounding = at_rounding_level(views, eps, rest_share(scene))

    def told(ways: np.ndarray) -> np.ndarray:
        """What the priors tell along some ways."""
        return end.problem.prior_errors(ways, best.factor, noise, precision)

    shift = np.hypot(best.shift, end.unsure)

    def errors_of(widen) -> tuple[Uncertainty, Held]:
        linear = best.factor, best.remainder, noise, best.values, unknowns
        return uncertainty_within(*linear, precision, RESOLVED * eps, shift, widen)

    known, held = errors_of(told)
    # What the solver left where it is as good as anywhere does not move; it is not determined.
    wide = known.seen & ~known.identifiable & [not c for c in known.confounded]
    seen = known if end.out_of_steps else replace(known, seen=known.seen & ~wide)
    step = unsettled(best.values, best.factor, best.remainder, seen, unknowns, precision, SETTLED, 0.05)
    found = Judged(
        best.values,
        best.films,
        known,
        on_bound(best.values, unknowns),
        [u.name for u, moves in zip(unknowns, step, strict=True) if moves],
        float(noise * np.sqrt(residual_count(targets)) * weighing.typical(targets)),
        noise,
        views,
        rounding,
        False,
    )
    if said := end.said:
        found.notes.append(said)
    if end.codec is not None:
        found.notes.append("what JPEG loses of the fitted picture is allowed for")
    if rounding:
        return found
    # Where pixels are whole numbers, the cells of their codes say more than their middles.
    other = held.any or end.problem.priors is not None or any(u.sums for u in unknowns) or weighing.robust
    codes = None if best.interrupted or end.problem.moves or other else by_codes(
        end.problem, targets, best.values, best.films, known.standard_error, weighing.deviations
    )  # fmt: skip
    structured = (
        is_structured(views, noises, len(unknowns))
        if codes is None
        else codes.standard is not None and neighbours_agree(codes.standard)
    )
    # Allow for what a codec leaves, which is known by example, and go along with neighbours as its examples do.
    examples = np.zeros((len(unknowns),) * 2)
    if end.codec is not None:
        departures = [found.departures for found in end.codec.examples(end.problem, best.values)]
        examples = scatter(end.problem, targets, best.values, departures)
        structured = structured and agree_more_than(views, noises, departures)
    # Allow for residuals of unequal size, and for those that go along with their neighbours'.
    said_by = None
    if structured or (weighing.estimated and codes is None):
        said_by = evidence(end.problem, targets, best.values, noise)

    def by_example(ways: np.ndarray) -> np.ndarray:
        inverse = np.linalg.pinv(ways)
        return np.sqrt(np.maximum(np.diagonal(inverse @ examples @ inverse.T), 0))

    def widen(ways: np.ndarray) -> np.ndarray:
        robust = {} if said_by is None else robust_errors(narrowed(said_by, ways), structured)
        return np.max([told(ways), by_example(ways), *(weighing.slack * error for error in robust.values())], axis=0)

    white = np.maximum(known.spread, by_example(np.eye(len(unknowns))))
    if codes is not None:
        found.values, found.films, found.views = codes.values, codes.films, views_of(targets, codes.films)
        found.at_bound = on_bound(codes.values, unknowns)
        widened = widen(np.eye(len(unknowns)))
        found.known = uncertainty(
            codes.factor, noise, codes.values, unknowns, precision, RESOLVED * eps, shift
        ).replaced(
            np.hypot(np.fmax(codes.error, widened), shift / QUANTILE),
            None if structured or shift.any() else codes.ends,
            codes.values,
            unknowns,
        )
        found.noise = codes.noise
        found.notes.append(_said_of_codes(codes.ends is not None))
    else:
        found.known, _ = errors_of(widen)
        widened = found.known.spread
    # Is the model wrong by more than intervals can carry?
    with np.errstate(all="ignore"):
        ratio = np.nanmax(np.where(known.identifiable & (white > 0), widened / white, 0), initial=0)
    # What a few edge pixels leave is not the model's fault: residuals count as the fit weighed them.
    left = found.noise if weighing.estimated else np.sqrt(np.mean([v.rmse**2 for v in views if v.weight.any()]))
    size = np.sqrt(
        np.mean([np.mean(np.square(v.target[v.weight > 0], dtype=np.float64)) for v in views if v.weight.any()])
    )
    found.misfit = bool(
        structured and ratio > SERIOUS and left > (VISIBLE_OF_TREES if end.problem.moves else VISIBLE) * size
    )
    if given and (times := times_the_noise(views, noises, len(unknowns))):
        found.misfit = True
        found.notes.append(f"what is left over is {times:.2g} times the noise that was given")
    if found.misfit and held.any and _by_bounds(end.problem, targets, best, noises, precision):
        # Without its bounds the model would fit far better: they are an answer, and not wrong by themselves.
        found.misfit = False
        names = [u.name for u, by in zip(unknowns, held.bound, strict=True) if by] or ["a sum"]
        found.notes.append(f"what is left over is mostly what the limit of {', '.join(names)} leaves")
    elif structured and not found.misfit:
        found.notes.append("what is left over goes along with its neighbours; the intervals allow for it")
    _say_what_is_coarse(found, best.shift, unknowns)
    return found


def _by_bounds(problem: Problem, targets: Sequence[CheckedTarget], best: Solution, noises, precision: float) -> bool:
    """Is what is left over the doing of bounds? A step without them would take much of it away, or leave noise."""
    if float(np.sum(best.remainder**2)) > BY_BOUNDS * 2 * best.loss:
        return True
    values = best.values + gauss_newton(best.factor, best.remainder, precision)
    for i, u in enumerate(problem.unknowns):
        # As far as numbers of its kind go; on a scale of logarithms no further than a factor of 2.
        ends = (best.values[i] / 2, 2 * best.values[i]) if u.row.measured_in.open else (u.row.lowest, u.row.highest)
        values[i] = np.clip(values[i], *ends)
    return not is_structured(views_of(targets, factorise(problem, values)[1]), noises, len(values))


def _said_of_codes(certain: bool) -> str:
    if certain:
        return "every pixel lies within the cell of its code: the intervals are certain bounds"
    return "the pictures are whole numbers: each pixel counts as lying within the cell of its code"


def _say_what_is_coarse(found: Judged, shifts: np.ndarray, unknowns) -> None:
    """Name the coefficients whose uncertainty is that of the trees."""
    coarse = [
        u.name
        for u, error, shift in zip(unknowns, found.known.standard_error, shifts, strict=True)
        if shift > MOSTLY * QUANTILE * error
    ]
    if coarse:
        which = ", ".join(coarse) if len(coarse) < 4 else f"{len(coarse)} coefficients"
        found.notes.append(
            f"the uncertainty of {which} is mostly what the ray trees leave out of a pixel; a larger footprint "
            "narrows it"
        )


def views_of(targets: Sequence[CheckedTarget], films: Sequence[np.ndarray]) -> tuple[FitView, ...]:
    """Target, render and residual of each target."""
    return tuple(_view(target, film) for target, film in zip(targets, films, strict=True))


def _view(target: CheckedTarget, film: np.ndarray) -> FitView:
    render = np.asarray(gathered(film, *target.mask.shape))
    used = target.mask > 0
    residual = np.where(used[..., None], render - target.image, 0).astype(np.float32)
    return FitView(
        target.name,
        target.image.astype(np.float32),
        render.astype(np.float32),
        residual,
        target.mask.astype(np.float32),
    )
