"""The drawings of a `Tradeoff` of pictures and of a `FitTradeoff`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from diffwhitted import KNOBS

from ._error_plot import Mark, Words, error_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ._tradeoff import Tradeoff
    from ._tradeoff_fit import FitTradeoff

LEAST_DRAWN = 1e-9
"""An error of 0 has no place on a logarithmic axis."""


def tradeoff_figure(found: Tradeoff, *inks: str) -> Figure:
    """RMSE against the time of a picture, with the tolerance; `inks`: of text and of lines."""
    marks = {
        p: Mark(
            str(p.settings), {knob.name: p.settings[knob] for knob in KNOBS}, p.sweeps, p.seconds, p.rmse, p.on_front
        )
        for p in found.points
    }
    words = Words(f"time for {found.width} x {found.height} pixels", "error: RMSE in linear RGB", *inks)
    own = [marks[p] for p in found.points if p.settings == found.asked]
    return error_figure(
        tuple(marks.values()),
        KNOBS,
        words,
        tolerance=found.tolerance,
        best=marks[found.recommended] if found.recommended else None,
        named=own,
    )


def fit_figure(found: FitTradeoff, *inks: str) -> Figure:
    """The largest error of a coefficient against the time of a fit."""
    marks = {
        p: Mark(str(p.settings), p.settings.named(), p.sweeps, p.seconds, max(p.largest, LEAST_DRAWN), p.on_front)
        for p in found.points
    }
    words = Words(
        f"time of a fit to {found.width} x {found.height} pixels",
        "largest error of a coefficient, share of its bounds",
        *inks,
    )
    own = [marks[p] for p in found.points if p.settings == found.default]
    return error_figure(
        tuple(marks.values()),
        found.default.knobs,
        words,
        best=marks[found.recommended] if found.recommended else None,
        named=own,
        idle=[mark for p, mark in marks.items() if not p.converged],
    )
