"""Sums of coefficients that have a limit, such as k_s + k_t <= 1; of colours, channel by channel."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from .._errors import FitError
from ._unknowns import Unknown, matching

CHANNELS = ("r", "g", "b")


def with_sums(unknowns: tuple[Unknown, ...], at_most: Mapping[str, float] | None) -> tuple[Unknown, ...]:
    """The unknowns with the sums that they are in, from `{"mirror.k_s+mirror.k_t": 1.0}`.

    Raises `FitError` for names that are not free, for what is not linear between its bounds, and for a limit that the
    lowest values exceed.
    """
    known = list(unknowns)
    for text, given in (at_most or {}).items():
        try:
            limit = float(given)
        except (TypeError, ValueError):
            limit = float("nan")
        names = [name.strip() for name in text.split("+")]
        if not isfinite(limit) or len(names) < 2 or len(set(names)) < len(names):
            raise FitError(
                f"at_most: {text} = {given!r}; allowed is NAME+NAME and a number, such as "
                '{"mirror.k_s+mirror.k_t": 1}'
            )
        parts = [matching(unknowns, name, "at_most") for name in names]
        for members in _by_channel(unknowns, parts, text):
            _check(unknowns, members, text, limit)
            entry = tuple(unknowns[i].name for i in members), limit
            for i in members:
                known[i] = replace(known[i], sums=(*known[i].sums, entry))
    return tuple(known)


def require_start(unknowns: Sequence[Unknown], values: np.ndarray) -> None:
    """Raise `FitError` where the values exceed a sum."""
    numbers = {u.name: i for i, u in enumerate(unknowns)}
    for names, limit in dict.fromkeys(entry for u in unknowns for entry in u.sums):
        total = float(sum(values[numbers[name]] for name in names))
        if total > limit + 1e-6:
            raise FitError(
                f"start: {' + '.join(names)} = {total:g} is above {limit:g}, the most that it may be (at_most); start "
                "lower, with start (--start)"
            )


def _by_channel(unknowns: Sequence[Unknown], parts: list[list[int]], text: str) -> list[tuple[int, ...]]:
    """The members of one sum, or of one for each channel; a grey number is in all of them."""
    if all(len(part) == 1 for part in parts):
        return [tuple(sorted(part[0] for part in parts))]
    sums = []
    for channel in CHANNELS:
        members = [next((i for i in part if unknowns[i].component in (channel, "")), None) for part in parts]
        if None in members or any(unknowns[i].component not in (*CHANNELS, "") for part in parts for i in part):
            raise FitError(f"at_most: {text}: allowed are single numbers and colours all of whose channels are free")
        sums.append(tuple(sorted(i for i in members if i is not None)))
    return sums


def _check(unknowns: Sequence[Unknown], members: tuple[int, ...], text: str, limit: float) -> None:
    for i in members:
        if unknowns[i].row.scale not in ("interval", "unbounded"):
            raise FitError(
                f"at_most: {text}: {unknowns[i].name} is looked for on a scale of logarithms and cannot be in a sum; "
                "give it bounds of its own (--bounds)"
            )
    if (least := sum(unknowns[i].bounds[0] for i in members)) >= limit:
        raise FitError(
            f"at_most: {text} = {limit:g}: the lowest values that the bounds allow come to {least:g} already; raise "
            "the limit, or lower the bounds"
        )
