"""What a deviation each residual has, by what residuals like it show."""

import numpy as np

from ..judging._variance import variance_of
from ..problem._problem import Problem
from ..problem._target import CheckedTarget
from ..problem._weighing import Weighing
from ..problem._whole_pictures import of_used, shown_by
from ..problem._within import within_pixels
from ._solve import Solution

FAR, OFTEN = 5.0, 1e-4
"""Tails are heavy where more than this share of residuals is so many deviations off (Gaussian: 6e-7)."""
TAIL = 3.0
"""Degrees of freedom of Student's t for residuals with heavy tails."""


def estimated(
    problem: Problem, targets: tuple[CheckedTarget, ...], weighing: Weighing, solution: Solution
) -> Weighing | None:
    """The deviations that the residuals show; None where they show that all are alike."""
    shown = shown_by(targets, solution.films)
    spread = [
        within if within.any() else bends_of(picture) for within, picture in zip(
            within_pixels(problem, solution.values), shown, strict=True)
    ]  # fmt: skip
    residual = of_used(targets, [picture - t.image for picture, t in zip(shown, targets, strict=True)])
    value = [np.maximum(picture, 0) for picture in shown]
    shapes = {"even": np.ones(len(residual)), "edges": of_used(targets, spread), "light": of_used(targets, value)}
    shapes = {name: shape for name, shape in shapes.items() if shape.any()}
    largest = float(np.abs(residual).max() + of_used(targets, value).max())
    floor = (float(np.finfo(problem.scene.dtype).eps) * largest) ** 2
    variance = variance_of(residual, shapes, floor)
    if variance.is_even and not weighing.estimated:
        return None
    deviations = [
        np.sqrt(variance.of({"even": np.ones_like(v), "edges": s, "light": v}) + floor)
        for v, s in zip(value, spread, strict=True)
    ]
    standard = of_used(targets, [(p - t.image) / d for p, t, d in zip(shown, targets, deviations, strict=True)])
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
