"""The next Gauss-Newton step within bounds and sums: which coefficients they hold, and along which ways the others may
move.

An active set (Gill, Murray and Wright 1981, 5.2): what the step would push beyond an end close by is held there, and
the step of the others is computed anew, along ways that keep to every sum that is held.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..problem._unknowns import Unknown, sums_of

SUM_SHARE = 1e-3
"""A sum so near to its limit, as a share of the limit (of 1 where that is 0), counts as having reached it."""


@dataclass(frozen=True)
class Held:
    """What is held: coefficients (p,) at a bound, and sums of coefficients, by their numbers."""

    bound: np.ndarray
    sums: tuple[tuple[int, ...], ...] = ()

    @property
    def any(self) -> bool:
        return bool(self.bound.any()) or bool(self.sums)

    def ways(self, also: int | None = None) -> tuple[np.ndarray, list[int]]:
        """The ways along which coefficients may move, (p, m), and the coefficient that each is a change of.

        `also`: one that may move although its bound holds it.
        """
        free = ~self.bound if also is None else ~self.bound | (np.arange(len(self.bound)) == also)
        ways, kept = np.eye(len(free))[:, free], np.flatnonzero(free).tolist()
        for members in self.sums:
            change = ways[list(members)].sum(axis=0)
            if not change.any():
                continue
            # The last one gives what the others take.
            last = int(np.flatnonzero(change)[-1])
            ways = np.delete(ways - np.outer(ways[:, last], change / change[last]), last, axis=1)
            del kept[last]
        return ways, kept


def active_step(
    values: np.ndarray,
    factor: np.ndarray,
    remainder: np.ndarray,
    free: np.ndarray,
    near: np.ndarray,
    unknowns: Sequence[Unknown],
    precision: float,
) -> tuple[np.ndarray, Held]:
    """The step -R^-1 q along the `free` coefficients, 0 for those that it would push through a bound no further than
    `near` (2, p), and what is held.
    """
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    sums, held = sums_of(unknowns), Held(~free)
    pushed = Held(np.zeros(len(unknowns), bool))
    for _ in range(len(unknowns) + len(sums) + 1):
        ways, _ = held.ways()
        step = ways @ gauss_newton(factor @ ways, remainder, precision)
        beyond = ~held.bound & (
            ((values + step < low) & (values - low < near[0])) | ((values + step > high) & (high - values < near[1]))
        )
        over = tuple(
            members
            for members, limit in sums
            if members not in held.sums
            and (values + step)[list(members)].sum() > limit
            and limit - values[list(members)].sum() < SUM_SHARE * (abs(limit) or 1)
        )
        if not (beyond.any() or over):
            break
        held = Held(held.bound | beyond, held.sums + over)
        pushed = Held(pushed.bound | beyond, held.sums)
    return step, pushed


def within(values: np.ndarray, step: np.ndarray, unknowns: Sequence[Unknown]) -> np.ndarray:
    """Where a step leads, no further than bounds and sums allow."""
    ends = np.clip(values + step, *np.asarray([u.bounds for u in unknowns], np.float64).T)
    for members, limit in sums_of(unknowns):
        before, after = values[list(members)].sum(), ends[list(members)].sum()
        if after > limit:
            ends = values + (ends - values) * max(limit - before, 0) / (after - before)
    return ends


def gauss_newton(factor: np.ndarray, remainder: np.ndarray, precision: float) -> np.ndarray:
    """-R^-1 q along the directions that R determines to its precision; columns of nothing stay."""
    size = np.linalg.norm(factor, axis=0)
    scale = np.where(size > 0, size, 1)
    if not factor.shape[1]:
        return np.zeros(0)
    return -np.linalg.lstsq(np.where(size > 0, factor / scale, 0), remainder, rcond=precision)[0] / scale


def strongly(held: Held, values: np.ndarray, factor: np.ndarray, remainder: np.ndarray, noise: float) -> Held:
    """What of it is held for certain: without it, the answer would go beyond by more than `STRONG` standard errors."""
    bound = held.bound.copy()
    for i in np.flatnonzero(held.bound):
        ways, _ = held.ways(int(i))
        bound[i] = _pushes(ways, ways[i], factor, remainder, noise)
    sums = []
    for members in held.sums:
        ways, _ = replace(held, sums=tuple(other for other in held.sums if other != members)).ways()
        if _pushes(ways, ways[list(members)].sum(axis=0), factor, remainder, noise):
            sums.append(members)
    return Held(bound, tuple(sums))


STRONG = 1.0


def _pushes(ways: np.ndarray, along: np.ndarray, factor: np.ndarray, remainder: np.ndarray, noise: float) -> bool:
    """Would a number that changes by `along` with each way go by more than `STRONG` standard errors?"""
    reduced = factor @ ways
    if not np.isfinite(noise) or noise == 0:
        return True
    size = np.linalg.norm(reduced, axis=0)
    scale = np.where(size > 0, size, 1)
    inverse = np.linalg.pinv(reduced / scale, rcond=1e-9)
    step, error = -along / scale @ inverse @ remainder, noise * np.linalg.norm(along / scale @ inverse)
    return bool(abs(step) > STRONG * error)
