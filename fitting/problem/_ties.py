"""Ties: one unknown for several coefficients, each a fixed multiple of one that leads."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .._errors import FitError
from ._unknowns import Unknown, matching


@dataclass(frozen=True)
class Ties:
    """All unknowns of the scene, and how they follow from those that the fit looks for."""

    all: tuple[Unknown, ...]
    leaders: tuple[Unknown, ...]
    matrix: np.ndarray
    """(all, leaders): the values of all are this times those of the leaders."""

    @property
    def any(self) -> bool:
        return len(self.all) > len(self.leaders)

    def leader(self, number: int) -> tuple[int, float]:
        """The leader of one of all, and how many times its value it has."""
        place = int(np.flatnonzero(self.matrix[number])[0])
        return place, float(self.matrix[number, place])


def tied(unknowns: tuple[Unknown, ...], ties: Mapping[str, str | tuple[float, str]] | None) -> Ties:
    """From `{"mirror.k_h": "mirror.k_s"}` or `{"mirror.k_h": "0.5*mirror.k_s"}`, with wildcards where all of one side
    follow one of the other.

    Raises `FitError` for names that are not free, that follow two, lead and follow, or cannot be equal within their
    bounds.
    """
    follows: dict[int, tuple[int, float]] = {}
    for name, given in (ties or {}).items():
        factor, leader = _factor(name, given)
        mine, theirs = matching(unknowns, name, "tie"), matching(unknowns, leader, "tie")
        if len(theirs) not in (1, len(mine)):
            raise FitError(
                f"tie: {name}={leader}: {len(mine)} number(s) cannot follow {len(theirs)}; name one channel each, or "
                "make both colours (--colour)"
            )
        for i, j in zip(mine, theirs * (len(mine) if len(theirs) == 1 else 1), strict=True):
            if i == j or i in follows:
                raise FitError(
                    f"tie: {unknowns[i].name} cannot follow {unknowns[j].name}; each follows one other, once"
                )
            follows[i] = j, factor
    for i, (j, _) in follows.items():
        if j in follows:
            raise FitError(
                f"tie: {unknowns[i].name} follows {unknowns[j].name}, which follows "
                f"{unknowns[follows[j][0]].name}; tie both to the last"
            )
    kept = [i for i in range(len(unknowns)) if i not in follows]
    leaders, matrix = {i: unknowns[i] for i in kept}, np.zeros((len(unknowns), len(kept)))
    for i in kept:
        matrix[i, kept.index(i)] = 1
    for i, (j, factor) in follows.items():
        matrix[i, kept.index(j)] = factor
        leaders[j] = _within_both(leaders[j], unknowns[i], factor)
    return Ties(unknowns, tuple(leaders[i] for i in kept), matrix)


def _factor(name: str, given) -> tuple[float, str]:
    """From "leader", "0.5*leader" or (0.5, "leader")."""
    factor, leader = given if isinstance(given, tuple) and len(given) == 2 else ("1", given)
    if isinstance(leader, str) and "*" in leader[1:] and not isinstance(given, tuple):
        before, _, after = leader.partition("*")
        try:
            factor, leader = str(float(before)), after.strip()
        except ValueError:
            pass  # A wildcard.
    try:
        number = float(factor)
    except (TypeError, ValueError):
        number = 0.0
    if not isinstance(leader, str) or not np.isfinite(number) or number == 0:
        raise FitError(f"tie: {name} = {given!r}; allowed is another name, or 0.5*NAME with a factor other than 0")
    return number, leader


def _within_both(leader: Unknown, follower: Unknown, factor: float) -> Unknown:
    """The leader within its own bounds and those that its follower puts on it."""
    ends = sorted(end / factor for end in follower.bounds)
    low, high = max(leader.bounds[0], ends[0]), min(leader.bounds[1], ends[1])
    if leader.counted or follower.counted or not low < high:
        raise FitError(
            f"tie: {follower.name} = {factor:g} * {leader.name} lies within the bounds of both for no value; "
            f"{leader.name} goes from {leader.bounds[0]:g} to {leader.bounds[1]:g}, {follower.name} from "
            f"{follower.bounds[0]:g} to {follower.bounds[1]:g}; widen them with bounds"
        )
    return replace(leader, bounds=(low, high))
