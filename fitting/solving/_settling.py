"""A fit from its first step to its last: how the targets are sampled, and how much each of their pixels counts.

The first solve takes every residual for as uncertain as every other. Where what it leaves over says otherwise (edges,
light, codes), the residuals are weighed by it, and the solve goes on from where it was.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from diffwhitted.image import gathered

from .._result import FitStep
from ..judging._misfit import at_rounding
from ..judging._rest import rest_share
from ..judging._variance import variance_of
from ..problem._problem import Problem, within_pixels
from ..problem._target import CheckedTarget
from ..problem._weighing import Weighing, weighed
from ._sampling import SIDE, Comparison, compared, sampled
from ._solve import Solution
from ._stages import run, stages_of

ROUNDS = 3
FAR, OFTEN = 5.0, 1e-4
"""Tails are heavy where more than this share of residuals is so many deviations off (Gaussian: 6e-7)."""
TAIL = 3.0
"""Degrees of freedom of Student's t for residuals with heavy tails."""
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
) -> Settled:
    """From a starting point. `sampling`: None where it is to be found out."""
    comparison, found_out = None, sampling is None
    eps, rest = float(np.finfo(problem.scene.dtype).eps), rest_share(problem.scene)

    def exact(solution: Solution) -> bool:
        pictures = [np.asarray(gathered(f, *t.image.shape[:2])) for f, t in zip(solution.films, targets, strict=True)]
        return all(
            at_rounding((picture - t.image)[t.mask > 0], t.image[t.mask > 0], eps, rest)
            for picture, t in zip(pictures, targets, strict=True)
        )

    def solved(problem: Problem, weighing: Weighing, point: np.ndarray, before: Solution | None) -> Solution:
        stages = stages_of(problem, targets, coarse_to_fine and before is None, weighing.unit)
        stages = stages if before is None else [stage for stage in stages if not stage.blur]
        steps = max_steps if before is None else max(max_steps - len(before.history), 2)
        return _after(before, run(stages, point, steps, on_step, weighing.total))

    # Find out at the start, as far as the residual tells by then.
    if found_out:
        comparison = compared(problem, start)
        sampling = comparison.better or "points"
        problem = sampled(problem, SIDE, start) if sampling == "pixel" else problem
    solution = solved(problem, weighing, start, None)
    # Look again where it is at rest.
    if found_out and not solution.interrupted and not exact(solution):
        comparison = compared(problem, solution.values)
        if comparison.better not in (None, sampling):
            sampling = comparison.better
            problem = sampled(problem, SIDE if sampling == "pixel" else 1, solution.values)
            solution = solved(problem, weighing, solution.values, solution)
    # Weigh each residual by what residuals like it show.
    for _ in range(ROUNDS):
        if targets[0].noise is not None or solution.interrupted or exact(solution):
            break
        new = estimated(problem, targets, weighing, solution)
        if new is None or (weighing.estimated and _change(new, weighing) < CHANGED):
            break
        problem, weighing = weighed(problem, targets, new), new
        solution = solved(problem, weighing, solution.values, solution)
    return Settled(solution, problem, weighing, sampling or "points", comparison)


def estimated(
    problem: Problem, targets: tuple[CheckedTarget, ...], weighing: Weighing, solution: Solution
) -> Weighing | None:
    """The deviations that the residuals show; None where they show that all are alike."""
    shown = [
        np.asarray(gathered(film, *t.image.shape[:2]), np.float64)
        for t, film in zip(targets, solution.films, strict=True)
    ]
    spread = [
        within if within.any() else bends_of(picture) for within, picture in zip(
            within_pixels(problem, solution.values), shown, strict=True)
    ]  # fmt: skip
    used = [np.broadcast_to((t.mask > 0)[..., None], t.image.shape) for t in targets]

    def of_used(pictures) -> np.ndarray:
        return np.concatenate([picture[where] for picture, where in zip(pictures, used, strict=True)])

    residual = of_used([picture - t.image for picture, t in zip(shown, targets, strict=True)])
    value = [np.maximum(picture, 0) for picture in shown]
    shapes = {"even": np.ones(len(residual)), "edges": of_used(spread), "light": of_used(value)}
    shapes = {name: shape for name, shape in shapes.items() if shape.any()}
    floor = (float(np.finfo(problem.scene.dtype).eps) * float(np.abs(residual).max() + of_used(value).max())) ** 2
    variance = variance_of(residual, shapes, floor)
    if variance.is_even and not weighing.estimated:
        return None
    deviations = [
        np.sqrt(variance.of({"even": np.ones_like(v), "edges": s, "light": v}) + floor)
        for v, s in zip(value, spread, strict=True)
    ]
    standard = of_used([(p - t.image) / d for p, t, d in zip(shown, targets, deviations, strict=True)])
    if np.mean(abs(standard) > FAR) < OFTEN:
        return Weighing(tuple(deviations), weighing.total, estimated=True)
    # Residuals with heavy tails weigh as those of Student's t do: less, the larger they are.
    heavy = [
        d * np.sqrt((TAIL + _per_pixel((p - t.image) / d)) / (TAIL + 1))
        for p, t, d in zip(shown, targets, deviations, strict=True)
    ]
    square = standard**2
    weight, slope = (TAIL + 1) / (TAIL + square), (TAIL + 1) * (TAIL - square) / (TAIL + square) ** 2
    return Weighing(tuple(heavy), weighing.total, True, float(max(weight.mean() / max(slope.mean(), 0.3), 1.0)))


def _per_pixel(standard: np.ndarray) -> np.ndarray:
    """The mean square of the channels of each pixel, for each of them."""
    return np.broadcast_to((standard**2).mean(axis=-1, keepdims=True), standard.shape)


def bends_of(picture: np.ndarray) -> np.ndarray:
    """The same by what the neighbours of a pixel show, of one sample a pixel: the square of what a straight course
    through them does not follow.
    """
    total = np.zeros_like(picture)
    for axis in (0, 1):
        room = [(0, 0)] * 3
        room[axis] = (1, 1)
        padded = np.pad(picture, room, mode="edge")
        count = picture.shape[axis]
        before, here, after = (np.take(padded, range(k, k + count), axis=axis) for k in range(3))
        total += (before - 2 * here + after) ** 2
    return total


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
