"""A result of the unknowns as one of all coefficients: those that follow others, and what priors and sums did."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diffwhitted.scene import Scene

from ._result import FitResult, FittedCoefficient
from .judging._active import SUM_SHARE
from .problem._ties import Ties
from .problem._unknowns import Unknown, free_as_named, insert

ALONG = 0.9
"""Correlation from which on a coefficient shares the fate of one that lies on its bound."""


def restricted(result: FitResult, scene: Scene, ties: Ties) -> FitResult:
    """The result with a coefficient for each of all unknowns, in their order; `scene`: what the fit began with."""
    coefficients = [
        replace(c, prior=u.prior, further=(*_reached(u, result.coefficients), *_beside(result, i)))
        for i, (c, u) in enumerate(zip(result.coefficients, ties.leaders, strict=True))
    ]
    if not ties.any:
        return replace(result, coefficients=tuple(coefficients))
    places, factors = zip(*map(ties.leader, range(len(ties.all))), strict=True)
    values = ties.matrix @ [c.value for c in coefficients]
    whole = [
        coefficients[place] if u.name == coefficients[place].name else _follower(coefficients[place], factor, u)
        for u, place, factor in zip(ties.all, places, factors, strict=True)
    ]
    sign = np.sign(factors)
    return replace(
        result,
        coefficients=tuple(whole),
        correlation=result.correlation[np.ix_(places, places)] * np.outer(sign, sign),
        scene=insert(scene, ties.all, values.astype(scene.dtype)),
        free=free_as_named(scene, ties.all),
    )


def _reached(unknown: Unknown, coefficients: Sequence[FittedCoefficient]) -> tuple[str, ...]:
    """A remark for each sum that has reached its limit."""
    values, said = {c.name: c.value for c in coefficients}, []
    for names, limit in unknown.sums:
        if limit - sum(values[name] for name in names) < SUM_SHARE * (abs(limit) or 1):
            said.append(f"{' + '.join(names)} is at its limit {limit:g}")
    return tuple(said)


def _beside(result: FitResult, number: int) -> tuple[str, ...]:
    """A remark for each coefficient on its bound with which this one goes along."""
    if result.coefficients[number].at_bound:
        return ()
    return tuple(
        f"goes along with {other.name}, which is at its {other.bound_reached}"
        for other, rho in zip(result.coefficients, result.correlation[number], strict=True)
        if other.at_bound and np.isfinite(rho) and abs(rho) > ALONG
    )


def _follower(leader: FittedCoefficient, factor: float, unknown: Unknown) -> FittedCoefficient:
    interval = leader.interval_95
    ends = None if interval is None else sorted(factor * end for end in interval)
    times = "equal to" if factor == 1 else f"{factor:g} times"
    return replace(
        leader,
        name=unknown.name,
        symbol=unknown.row.symbol,
        value=factor * leader.value,
        start=factor * leader.start,
        standard_error=None if leader.standard_error is None else abs(factor) * leader.standard_error,
        interval_95=None if ends is None else (ends[0], ends[1]),
        shift=abs(factor) * leader.shift,
        bounds=unknown.bounds,
        unit=unknown.unit,
        moves=unknown.row.moves,
        prior=None,
        further=(f"{times} {leader.name}, as asked",),
        tied_to=leader.name,
    )
