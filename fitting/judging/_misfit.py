"""Is what a fit leaves over noise? Where it is not, its standard errors, which take it for noise, are too small.

Independent noise knows nothing of its neighbour, so for residuals z of neighbouring pixels i, j

    t = sum z_i z_j / sqrt(sum (z_i z_j)^2)

has mean 0 and variance 1, whatever the distribution of z: each product is as often negative as positive. What a model
lacks is nearly the same in neighbouring pixels and gives a large positive t. Channels are summed first, since
their noise may be common. A few pixels that are far off cannot raise t: with one large product t is 1.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .._result import FitView

CLEARLY = 5.0
"""Independent noise exceeds this t in fewer than one of a million fits."""
TWICE = 2.0
"""A residual so many times the given noise is more than that noise."""
ROUNDING = 64.0
"""A residual below so many units in the last place of the picture is the rounding of two renders."""


def at_rounding_level(views: tuple[FitView, ...], eps: float, at_rest: float) -> bool:
    """Is the residual no more than the arithmetic leaves over, or a solver that rests at steps of the share
    `at_rest`?
    """
    return all(at_rounding(v.residual[v.weight > 0], v.target[v.weight > 0], eps, at_rest) for v in views)


def at_rounding(residual: np.ndarray, target: np.ndarray, eps: float, at_rest: float) -> bool:
    """Is this residual of these values no more than that?"""
    return _root_mean_square(residual) <= max(ROUNDING * eps, 2 * at_rest) * _root_mean_square(target)


def is_structured(views: tuple[FitView, ...], noises: tuple[np.ndarray | None, ...], unknowns: int) -> bool:
    """Do neighbouring residuals agree more than independent noise would, or is the residual well above a given noise?

    Where a noise is given and the residual is far below it, structure in the residual does not matter.
    """
    scaled = [_scaled(view, noise) for view, noise in zip(views, noises, strict=True)]
    if noises[0] is not None:
        size, loud = _beside_noise(views, scaled, unknowns)
        if loud or size < TWICE**-2:
            return loud
    return neighbours_agree(scaled)


def times_the_noise(views: tuple[FitView, ...], noises: tuple[np.ndarray | None, ...], unknowns: int) -> float:
    """How many times a given noise the residual is (RMS), where that is clearly more than twice; else 0."""
    size, loud = _beside_noise(views, [_scaled(v, n) for v, n in zip(views, noises, strict=True)], unknowns)
    return size**0.5 if loud else 0.0


def _beside_noise(views: Sequence[FitView], scaled: Sequence[np.ndarray], unknowns: int) -> tuple[float, bool]:
    """The mean square of residuals in units of the noise, for the degrees of freedom, and whether that is clearly more
    than twice the noise; 1 where there are no degrees of freedom.
    """
    used = sum(float(view.weight.sum()) * 3 for view in views)
    count = sum(3 * int((view.weight > 0).sum()) for view in views)
    if count <= unknowns:
        return 1.0, False
    size = sum(float((z**2).sum()) for z in scaled) / used * count / (count - unknowns)
    return size, size > TWICE**2 and size - 1 > CLEARLY * (2 / (count - unknowns)) ** 0.5


def neighbours_agree(standard: Sequence[np.ndarray]) -> bool:
    """Do neighbours in these pictures, (height, width, channels), agree more than independent ones would?"""
    products = np.concatenate([_neighbours(z) for z in standard])
    return bool(products.sum() > CLEARLY * np.sqrt((products**2).sum()))


def agree_more_than(
    views: Sequence[FitView], noises: Sequence[np.ndarray | None], examples: Sequence[np.ndarray]
) -> bool:
    """Do neighbours agree more than in examples of what may be left, (examples, height, width, 3) for each view?"""

    def agreement(residuals: Sequence[np.ndarray]) -> float:
        changed = [replace(view, residual=r.astype(np.float32)) for view, r in zip(views, residuals, strict=True)]
        scaled = [_scaled(view, noise) for view, noise in zip(changed, noises, strict=True)]
        return float(sum(_neighbours(z).sum() for z in scaled))

    usual = [agreement([example[k] for example in examples]) for k in range(len(examples[0]))]
    return bool(agreement([view.residual for view in views]) > np.mean(usual) + CLEARLY * np.std(usual))


def _scaled(view: FitView, noise: np.ndarray | None) -> np.ndarray:
    """The residual in units of the given noise, weighted as in the fit; 0 outside the mask."""
    z = np.asarray(view.residual, np.float64) * np.sqrt(np.asarray(view.weight, np.float64))[..., None]
    return z if noise is None else z / noise


def _neighbours(z: np.ndarray) -> np.ndarray:
    """The products of all pixels with the next one to the right and below."""
    across, down = (z[:, 1:] * z[:, :-1]).sum(axis=2), (z[1:] * z[:-1]).sum(axis=2)
    return np.concatenate([across.ravel(), down.ravel()])


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64)))) if values.size else 0.0
