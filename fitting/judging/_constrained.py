"""What the pictures determine where bounds or sums hold some coefficients.

What is held for certain does not move with the noise: the others' standard errors are those along the ways that are
left, and a held coefficient has those of the problem in which it alone may move inward. Its interval has one side.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..problem._unknowns import Unknown
from ._active import Held, active_step, strongly
from ._identifiability import QUANTILE, Uncertainty, uncertainty
from ._rest import near_bounds, on_bound

ONE_SIDED = 1.644854
"""A Gaussian is above so many standard deviations once in twenty times."""


def uncertainty_within(
    factor: np.ndarray,
    remainder: np.ndarray,
    noise: float,
    values: np.ndarray,
    unknowns: tuple[Unknown, ...],
    precision: float,
    resolution: float,
    shift: np.ndarray,
    widen: Callable[[np.ndarray], np.ndarray],
) -> tuple[Uncertainty, Held]:
    """As `uncertainty`, and what is held. `widen(ways)`: standard errors along some ways, of other causes."""

    def along(ways: np.ndarray, kept: list[int]) -> Uncertainty:
        mine = tuple(unknowns[k] for k in kept)
        reduced, widened = factor @ ways, widen(ways) if kept else np.zeros(0)
        return uncertainty(reduced, noise, values[kept], mine, precision, resolution, shift[kept], widened)

    count = len(unknowns)
    known = along(np.eye(count), list(range(count)))
    at_bound = on_bound(values, unknowns)
    _, held = active_step(
        values, factor, remainder, known.seen, near_bounds(unknowns, known.standard_error), unknowns, precision
    )
    held = strongly(replace(held, bound=held.bound & at_bound), values, factor, remainder, noise)
    if held.any:
        known = _spread_out(known, held, values, along)
    if at_bound.any() or held.any:
        known = replace(known, interval=_one_sided(known, at_bound, values, unknowns))
    return known, held


def _spread_out(
    whole: Uncertainty, held: Held, values: np.ndarray, along: Callable[[np.ndarray, list[int]], Uncertainty]
) -> Uncertainty:
    """The uncertainty of all coefficients from that of the ways that are left."""
    ways, kept = held.ways()
    left, count = along(ways, kept), len(whole.spread)
    linear = left.correlation * np.outer(left.spread, left.spread)
    covariance = ways @ np.where(np.isfinite(linear), linear, 0) @ ways.T
    spread, error = np.sqrt(np.maximum(np.diagonal(covariance), 0)), np.full(count, np.nan)
    sure, interval = np.zeros(count, bool), np.full((count, 2), np.nan)
    confounded: list[tuple[int, ...]] = [()] * count
    error[kept], sure[kept], interval[kept] = left.standard_error, left.identifiable, left.interval
    for column, k in enumerate(kept):
        confounded[k] = tuple(kept[j] for j in left.confounded[column])
    # What gives what the others take, along a sum.
    for i in set(range(count)) - set(kept) - set(np.flatnonzero(held.bound)):
        parts = np.flatnonzero(ways[i])
        sure[i] = bool(left.identifiable[parts].all())
        error[i] = spread[i] if sure[i] and np.isfinite(left.standard_error[parts]).all() else np.nan
        confounded[i] = tuple(sorted({j for part in parts for j in confounded[kept[part]]} - {i}))
        interval[i] = values[i] + np.array([-1, 1]) * QUANTILE * error[i]
    sizes = np.where(spread > 0, spread, np.inf)
    correlation = np.clip(covariance / np.outer(sizes, sizes), -1, 1)
    for i in np.flatnonzero(held.bound):
        inward, whose = held.ways(int(i))
        one = along(inward, whose)
        place = whose.index(int(i))
        spread[i], error[i], sure[i] = one.spread[place], one.standard_error[place], whole.seen[i]
        if not np.isfinite(error[i]) and sure[i] and not one.confounded[place]:
            error[i] = spread[i]  # Wider than its bounds: an interval from end to end.
        correlation[i, whose] = correlation[whose, i] = one.correlation[place]
    np.fill_diagonal(correlation, 1)
    return replace(
        whole,
        spread=spread,
        standard_error=error,
        interval=interval,
        identifiable=sure,
        confounded=tuple(confounded),
        correlation=correlation,
    )


def _one_sided(known: Uncertainty, at_bound: np.ndarray, values: np.ndarray, unknowns) -> np.ndarray:
    """The intervals, of what lies on a bound from there inward."""
    ends = known.interval.copy()
    for i in np.flatnonzero(at_bound & np.isfinite(known.standard_error)):
        unknown, scale = unknowns[i], unknowns[i].row.measured_in
        low, high = unknown.bounds
        half = ONE_SIDED * known.standard_error[i] * scale.slope(values[i])
        inward = 1 if values[i] - low < high - values[i] else -1
        ends[i] = np.sort([low if inward > 0 else high, scale.inverse(scale.forward(values[i]) + inward * half)])
    return np.clip(ends, *np.asarray([u.bounds for u in unknowns]).T[:, :, None].repeat(2, axis=2))
