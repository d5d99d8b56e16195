"""A fit from its first step to its last: how the targets are sampled, and how much each of their pixels counts.

The first solve takes every residual for as uncertain as every other. Where what it leaves over says otherwise (edges,
light, codes), the residuals are weighed by it, and the solve goes on from where it was.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .._result import FitStep
from ..judging._misfit import at_rounding
from ..judging._rest import jacobian_precision, residual_noise, rest_share
from ..judging._wild import absurd, ruling
from ..problem._problem import Problem
from ..problem._target import CheckedTarget, residual_count
from ..problem._views import retargeted
from ..problem._weighing import Weighing, first_weighing, weighed
from ..problem._whole_pictures import shown_by
from ._estimating import estimated
from ._lossy import ROUNDS as CODEC_ROUNDS
from ._lossy import Codec
from ._lossy import is_known as known_losses
from ._robust import HUBER_ROUNDS, reweighed
from ._sampling import SIDE, Comparison, compared, moved_by_spread, sampled, spread_of
from ._solve import Solution
from ._stages import run, stages_of

ROUNDS = 3
LOSS_ROUNDS = 20
ALIKE = 0.02
"""Priors whose weights change by a smaller share weigh what they did."""
CHANGED = 0.1
"""Deviations that change by a smaller share (root of the mean square of their logarithm) are what they were."""


@dataclass(frozen=True)
class Settled:
    """Where a fit ended, and what it was then."""

    solution: Solution
    problem: Problem
    weighing: Weighing
    sampling: str
    """"points" or "pixel"."""
    comparison: Comparison | None
    """Where it was found out."""
    targets: tuple[CheckedTarget, ...]
    """As the fit used them: without a few wild pixels, where these carried nearly all that was left over."""
    out_of_steps: bool
    """It ended since it had no more steps to take."""
    unsure: np.ndarray | float = 0.0
    """By how much each coefficient hangs on how the samples of a pixel are spread, half a 95 % interval, (p,)."""
    codec: Codec | None = None
    """What the targets were compressed by, where the fit allowed for it."""

    @property
    def said(self) -> str:
        """What was found out, in words; empty where nothing was."""
        if self.comparison is None:
            return ""
        points, pixel = self.comparison.points, self.comparison.pixel
        if self.comparison.better is None:
            return ""
        kind, other, more = (
            ("averages over its pixels, and so does the fit", "points", points / max(pixel, 1e-3 * points))
            if self.sampling == "pixel"
            else ("is sampled at points", "averages over pixels", pixel / max(points, 1e-3 * pixel))
        )
        times = "a thousand times or more" if more > 999 else f"{more:.2g} times"
        return f"the target {kind}: {other} would leave {times} the residual"

    @property
    def remainder(self) -> float:
        """Root of the sum of squares of what is left over, whatever its weights."""
        views = zip(self.problem.views, self.solution.films, strict=True)
        left = [(np.asarray(v.picture(film)) - v.image)[v.weight[..., 0] > 0] for v, film in views]
        return float(np.sqrt(sum(np.sum(part.astype(np.float64) ** 2) for part in left)))


def settle(
    problem: Problem,
    targets: tuple[CheckedTarget, ...],
    weighing: Weighing,
    start: np.ndarray,
    *,
    sampling: str | None,
    max_steps: int,
    coarse_to_fine: bool,
    on_step: Callable[[FitStep], None] | None,
    loss: str = "square",
) -> Settled:
    """From a starting point. `sampling`: None where it is to be found out; `loss`: how much large residuals count."""
    comparison, found_out = None, sampling is None
    eps, rest = float(np.finfo(problem.scene.dtype).eps), rest_share(problem.scene)

    def exact(solution: Solution) -> bool:
        return all(
            at_rounding((picture - t.image)[t.mask > 0], t.image[t.mask > 0], eps, rest)
            for picture, t in zip(shown_by(targets, solution.films), targets, strict=True)
        )

    def solved(problem: Problem, weighing: Weighing, point: np.ndarray, before: Solution | None):
        """The solution, and the problem with its priors beside the noise that it shows."""
        solution = once(problem, weighing, point, before)
        for _ in range(ROUNDS):
            new = with_noise(problem, targets, weighing, solution)
            if new is None or solution.interrupted:
                break
            problem, solution = new, once(new, weighing, solution.values, solution)
        return problem, solution

    def once(problem: Problem, weighing: Weighing, point: np.ndarray, before: Solution | None) -> Solution:
        stages = stages_of(problem, targets, coarse_to_fine and before is None, weighing.unit)
        stages = stages if before is None else [stage for stage in stages if not stage.blur]
        steps = max_steps if before is None else max(max_steps - len(before.history), 2)
        return _after(before, run(stages, point, steps, on_step, weighing.total))

    def without(wild: list[np.ndarray]) -> None:
        """Go on with targets without these pixels."""
        nonlocal targets, problem, weighing
        targets = tuple(
            replace(t, mask=np.where(w, 0, t.mask), image=np.where(w[..., None], 0, t.image))
            for t, w in zip(targets, wild, strict=True)
        )
        weighing = first_weighing(targets, float(residual_count(targets)))
        problem = weighed(problem, targets, weighing)

    if (wild := absurd(targets)) is not None:
        without(wild)
    # Find out at the start, as far as the residual tells by then.
    if found_out:
        comparison = compared(problem, start)
        sampling = comparison.better or "points"
        problem = sampled(problem, SIDE, start) if sampling == "pixel" else problem
    problem, solution = solved(problem, weighing, start, None)
    # Begin anew without a few pixels that carry nearly all that is left over.
    for _ in range(ROUNDS):
        if solution.interrupted or exact(solution):
            break
        wild = ruling(targets, shown_by(targets, solution.films), eps)
        if wild is None:
            break
        without(wild)
        problem, solution = solved(problem, weighing, start, None)
    # Look again where it is at rest.
    if found_out and not solution.interrupted and not exact(solution):
        comparison = compared(problem, solution.values)
        if comparison.better not in (None, sampling):
            sampling = comparison.better
            problem = sampled(problem, SIDE if sampling == "pixel" else 1, solution.values)
            problem, solution = solved(problem, weighing, solution.values, solution)
    # Weigh each residual as the loss says, or by what residuals like it show.
    first = weighing
    for number in range(LOSS_ROUNDS if loss != "square" else 0):
        if solution.interrupted or exact(solution):
            break
        name = "huber" if loss == "tukey" and number < HUBER_ROUNDS else loss
        new = reweighed(name, targets, weighing, first, solution, eps)
        settled = weighing.robust and name == loss and _change(new, weighing) < CHANGED / 10
        problem, weighing = weighed(problem, targets, new), new
        if settled:
            break
        problem, solution = solved(problem, weighing, solution.values, solution)

    def weigh() -> None:
        """Weigh them by what residuals like them show, and solve again, until the weights stay."""
        nonlocal problem, weighing, solution
        for _ in range(ROUNDS if loss == "square" and targets[0].noise is None else 0):
            if solution.interrupted or exact(solution):
                break
            new = estimated(problem, targets, weighing, solution)
            if new is None or (weighing.estimated and _change(new, weighing) < CHANGED):
                break
            problem, weighing = weighed(problem, targets, new), new
            problem, solution = solved(problem, weighing, solution.values, solution)

    def without_losses() -> Codec:
        """Go on with targets without what their codec lost of what is fitted."""
        nonlocal targets, problem, solution
        codec = Codec(targets)
        for _ in range(CODEC_ROUNDS):
            examples = codec.examples(problem, solution.values)
            targets = codec.corrected(examples)
            codec = codec.as_noisy(shown_by(targets, solution.films), examples)
            views = zip(problem.views, targets, strict=True)
            problem = replace(problem, views=tuple(retargeted(view, t.image) for view, t in views))
            problem, solution = solved(problem, weighing, solution.values, solution)
            weigh()
        return codec

    weigh()
    # Find out how the samples of a pixel are spread.
    unsure, spread = np.zeros_like(solution.values), None
    for _ in range(ROUNDS if found_out and sampling == "pixel" else 0):
        if solution.interrupted or exact(solution):
            break
        noise = residual_noise(targets, solution.loss, len(problem.unknowns), weighing.unit, problem.scene)
        new, before = spread_of(problem, solution.values, noise), spread
        if new is None:
            break
        spread, problem = new, sampled(problem, SIDE, solution.values, new.moment)
        problem, solution = solved(problem, weighing, solution.values, solution)
        weigh()
        if before is not None and abs(new.moment - before.moment) < new.error:
            break
    if spread is not None and not solution.interrupted:
        unsure = moved_by_spread(problem, solution.values, spread)
    codec = None
    if loss == "square" and known_losses(targets) and not (problem.moves or solution.interrupted or exact(solution)):
        codec = without_losses()
    ended = len(solution.history) >= max_steps
    return Settled(solution, problem, weighing, sampling or "points", comparison, targets, ended, unsure, codec)


def with_noise(
    problem: Problem, targets: tuple[CheckedTarget, ...], weighing: Weighing, solution: Solution
) -> Problem | None:
    """The problem with its priors beside the noise that the residuals show; None where they are so already."""
    if problem.priors is None:
        return None
    noise = residual_noise(targets, solution.loss, len(problem.unknowns), weighing.unit, problem.scene)
    if not np.isfinite(noise):
        return None
    new = problem.priors.weighed(noise, solution.factor, jacobian_precision(problem.scene))
    known = np.isfinite(new.deviation)
    if np.allclose(np.log(new.weight[known] / problem.priors.weight[known]), 0, atol=ALIKE):
        return None
    return replace(problem, priors=new)


def _change(new: Weighing, old: Weighing) -> float:
    """Root of the mean square of the change of the deviations' logarithm."""
    logs = [np.log(a / b) for a, b in zip(new.deviations, old.deviations, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate([log.ravel() for log in logs]) ** 2)))


def _after(before: Solution | None, solution: Solution) -> Solution:
    """The solution with the steps of the one before it."""
    if before is None:
        return solution
    history = tuple(
        replace(step, step=len(before.history) + n, seconds=before.seconds + step.seconds)
        for n, step in enumerate(solution.history)
    )
    return replace(
        solution,
        history=(*before.history, *history),
        stages=(*before.stages, *solution.stages),
        seconds=before.seconds + solution.seconds,
        shift=np.maximum(before.shift, solution.shift),
    )
