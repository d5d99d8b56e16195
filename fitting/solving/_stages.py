"""From coarse to fine: a fit takes its first steps where they cost little, and its last where they count.

Where no ray moves, every pixel alone is a measurement, and some passes of a large target, whose pixels come from all
over it, lead nearly to where all of them lead. Where rays move, residuals are blurred at first (`_pyramid`), and what
is blurred over several pixels needs no tree for each of them. The last stage looks at all pixels, and what a fit
reports is from there.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from diffwhitted.numerics._workers import processors

from .._result import FitStage, FitStep
from ..judging._rest import nearly, off_bound, rest_test
from ..problem._problem import Problem
from ..problem._pyramid import blurs
from ..problem._target import CheckedTarget
from ..problem._views import coarser, finer, some_passes
from ..problem._weighing import UNIT
from ._scan import best_of
from ._solve import Solution, solve

LEAST_SAMPLES = 2**14
"""No look is at fewer pixels, if there are so many."""
SHARE = 4
"""One pass of so many, or fewer, are looked at first."""
ERRORS = 0.1
"""A look at some pixels goes on until a step is this share of the standard error that these pixels leave."""


@dataclass(frozen=True)
class Stage:
    """A stretch of a fit: what it looks at, blurred by how many pixels, and when it ends."""

    name: str
    problem: Problem
    blur: float
    at_rest: Callable[..., bool]
    whole: bool
    """It looks at all pixels, sharply."""

    @property
    def samples(self) -> int:
        return sum(int(np.sum(part.there)) for view in self.problem.views for part in view.parts)


def stages_of(
    problem: Problem, targets: tuple[CheckedTarget, ...], coarse_to_fine: bool, unit: float = UNIT
) -> list[Stage]:
    """The stages of a fit, in order. `unit` of the residuals: the least that they are divided by."""

    def rest(errors: float = 0.005):
        return rest_test(problem.scene, targets, problem.unknowns, unit, errors)

    def settled(values, factor, remainder, loss) -> bool:
        return nearly(values, factor, remainder, problem.unknowns, 1e-4)

    moving, found = problem.moves, []
    width, height = problem.views[0].parts[0].plan.picture
    fewest = min(view.weight[..., 0].size for view in problem.views)
    # Blur what edges tell; light and shadow tell of a light from far enough (measured: a blur leads away from it).
    rows = [u.row for u in problem.unknowns]
    blurred = any(row.moves in ("rays", "patterns") for row in rows) and not any(row.blurs for row in rows)
    for blur in blurs(width, height)[:-1] if blurred else ():
        step = _step(fewest, blur) if coarse_to_fine else 1
        squares = f"squares of {step} x {step} pixels, " if step > 1 else ""
        found.append(
            Stage(f"{squares}blurred by {blur:.3g} pixels", _changed(problem, coarser, step), blur, settled, False)
        )
    passes = min(view.passes for view in problem.views)
    count = max(1, min(processors(), passes // SHARE))
    alone = all(view.filter == "box" for view in problem.views)
    if coarse_to_fine and passes >= SHARE and alone:
        errors = ERRORS * (passes / count) ** 0.5
        found.append(
            Stage(f"one pixel in {passes // count}", _changed(problem, some_passes, count), 0.0, rest(errors), False)
        )
    found.append(Stage("all pixels", problem, 0.0, rest(), True))
    if moving and problem.views[0].parts[0].plan.footprint:
        found.append(Stage("all pixels, 2 x 2 trees in place of each", _changed(problem, finer), 0.0, rest(), True))
    return found


def _changed(problem: Problem, change: Callable, *how) -> Problem:
    """The problem with each of its views changed."""
    return replace(problem, views=tuple(change(view, *how) for view in problem.views))


def _step(pixels: int, blur: float) -> int:
    """The largest power of 2 up to half the blur that leaves pixels enough of so many."""
    step = 1
    while 4 * step <= blur and pixels >= 4 * step**2 * LEAST_SAMPLES:
        step *= 2
    return step


def run(
    stages: list[Stage], point: np.ndarray, max_steps: int, on_step: Callable[[FitStep], None] | None, scale: float
) -> Solution:
    """All stages from a starting point. Where rays move, it begins at a better place if a look along them finds one."""
    history, made, begun = [], [], time.perf_counter()

    def seen(step: FitStep):
        history.append(replace(step, step=len(history), seconds=time.perf_counter() - begun))
        if on_step is not None:
            on_step(history[-1])

    def solved(stage: Stage, point: np.ndarray, most: int, since: float, boldness: float | None) -> Solution:
        solution = solve(
            stage.problem,
            point,
            max_steps=most,
            at_rest=stage.at_rest,
            on_step=seen,
            loss_scale=scale,
            sigma=stage.blur,
            boldness=boldness,
        )
        made.append(FitStage(stage.name, stage.samples, len(solution.history), time.perf_counter() - since))
        return solution

    boldness = None
    for number, stage in enumerate(stages):
        since, before = time.perf_counter(), point
        if number == 0 and stage.blur:
            point = best_of(stage.problem, point, stage.blur)
        solution = solved(stage, point, max_steps, since, boldness)
        point = solution.values if stage.whole or stage.blur else off_bound(solution.values, stage.problem.unknowns)
        # Go on as bold as before on sharp residuals, but not as timid as where steps were refused to the end.
        boldness = solution.boldness if not stage.blur and solution.history[-1].accepted else None
        if solution.interrupted:
            break
    if not stage.whole:
        last = next(stage for stage in stages if stage.whole)
        solution = replace(solved(last, point, 1, time.perf_counter(), None), interrupted=True)
    several = number > 0 and stages[number - 1].whole
    return replace(
        solution,
        history=tuple(history),
        stages=tuple(made),
        seconds=time.perf_counter() - begun,
        shift=abs(solution.values - before) if several else solution.shift,
    )
