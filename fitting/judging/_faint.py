"""Highlights that do not stand out of the noise: there is none, or one that lies between the pixels.

Where a fit looks for both, k_h and its exponent, a highlight that no pixel shows may be strong and sharp as well as
faint or absent. The standard errors, which are those at the exponent that was found, know of the latter only.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..problem._problem import Problem, factorise
from ..problem._unknowns import Unknown
from ._identifiability import QUANTILE, WIDEST, Uncertainty

STANDS_OUT = 5.0
"""A highlight is seen whose k_h, over its channels, is so many standard errors from zero."""


@dataclass(frozen=True)
class Faint:
    """A highlight that does not stand out: numbers of unknowns."""

    exponent: int
    shares: tuple[int, ...]
    """Its k_h."""


def faint_highlights(unknowns: Sequence[Unknown], values: np.ndarray, known: Uncertainty) -> tuple[Faint, ...]:
    """The highlights, k_h and exponent of which are free, that do not stand out of the noise."""
    found = []
    for i, unknown in enumerate(unknowns):
        if unknown.row.name != "phong_exponent":
            continue
        owner = unknown.parameter.owner
        shares = [j for j, u in enumerate(unknowns) if u.row.name == "k_h" and u.parameter.owner == owner]
        sure = [j for j in shares if np.isfinite(known.standard_error[j])]
        if sure and _distance(sure, i, values, known) < STANDS_OUT:
            found.append(Faint(i, tuple(shares)))
    return tuple(found)


def _distance(shares: list[int], exponent: int, values: np.ndarray, known: Uncertainty) -> float:
    """How many standard errors some k_h are from zero at this exponent."""
    correlation = known.correlation[np.ix_(shares, shares)]
    if np.isfinite(known.standard_error[exponent]):
        along = known.correlation[shares, exponent]
        correlation = correlation - np.outer(along, along)
    scaled = values[shares] / np.maximum(known.standard_error[shares], np.finfo(float).tiny)
    return float(np.sqrt(max(scaled @ np.linalg.pinv(correlation) @ scaled, 0)))


def with_faint(
    known: Uncertainty, faint: Sequence[Faint], problem: Problem, values: np.ndarray, noise: float
) -> Uncertainty:
    """What the pictures determine, where these highlights may be as sharp as their bounds allow.

    The exponents are not determined. A k_h has the interval that holds at the largest exponent too; it is not
    determined if hardly any pixel would show such a highlight.
    """
    unknowns, sharpest = problem.unknowns, values.copy()
    for highlight in faint:
        sharpest[highlight.exponent] = unknowns[highlight.exponent].bounds[1]
    factor, _ = factorise(problem, sharpest)
    size = np.linalg.norm(factor[:-1, :-1], axis=0)
    sure, error, interval = known.identifiable.copy(), known.standard_error.copy(), known.interval.copy()
    for highlight in faint:
        sure[highlight.exponent] = False
        for j in highlight.shares:
            low, high = unknowns[j].bounds
            worst = noise / size[j] if size[j] > 0 else np.inf
            sure[j] &= worst < WIDEST * (high - low)
            error[j] = max(error[j], worst)
            interval[j, 1] = min(max(interval[j, 1], values[j] + QUANTILE * worst), high)
    error, interval = np.where(sure, error, np.nan), np.where(sure[:, None], interval, np.nan)
    return replace(known, identifiable=sure, standard_error=error, interval=interval)


def said_of(faint: Sequence[Faint], unknowns: Sequence[Unknown]) -> str:
    names = ", ".join(unknowns[highlight.exponent].parameter.owner for highlight in faint)
    return (
        f"no highlight of {names} stands out of the noise: there is none, or it lies between the pixels; give a "
        "phong_exponent, or a larger picture"
    )
