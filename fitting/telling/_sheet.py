"""All shots of a fit on one sheet: target, fit and residual side by side, the residuals on one scale."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .._result import FitView

LARGEST_SIDE = 240
"""Pixels of a picture on the sheet; larger ones are averaged down."""
FEWEST = 2
"""Views for which there is a sheet."""


def contact_sheet(
    views: Sequence[FitView], left_out: Sequence[str], draw: Callable[[FitView, int, float], dict[str, Any]]
) -> dict[str, Any] | None:
    """What the sheet shows of each view; None of a single one.

    `left_out`: the names of those that the fit did not look at; `draw`: the pictures of a view, means over squares of
    so many pixels, with residuals up to so much.
    """
    if len(views) < FEWEST:
        return None
    reach = max(worst_of(view) for view in views)
    rows = []
    for view in views:
        used = np.asarray(view.weight) > 0
        size = np.square(np.asarray(view.target, np.float64)[used]).mean() ** 0.5 if used.any() else 0.0
        rows.append(
            {
                "name": view.camera,
                "left_out": view.camera in left_out,
                "pixels": int(used.sum()),
                "rmse": view.rmse,
                "share": view.rmse / size if size > 0 else None,
                "mean": float(np.asarray(view.residual, np.float64)[used].mean()) if used.any() else None,
                **draw(view, math.ceil(max(used.shape) / LARGEST_SIDE), reach),
            }
        )
    return {"rows": rows, "reach": reach}


def worst_channel(view: FitView) -> np.ndarray:
    """The residual of the channel that is furthest off, with its sign: no error can cancel another."""
    residual = np.asarray(view.residual, np.float64)
    return np.take_along_axis(residual, np.abs(residual).argmax(axis=-1)[..., None], axis=-1)[..., 0]


def worst_of(view: FitView) -> float:
    """Residuals that are larger are one in two hundred at most."""
    used = np.abs(worst_channel(view)[np.asarray(view.weight) > 0])
    return float(np.percentile(used, 99.5)) if used.size else 0.0
