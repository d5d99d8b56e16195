"""The end of a fit to pictures of whole numbers: from least squares to what the cells of the codes say."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..judging._codes import Cells, bounds_of_polytope, most_likely, standardised
from ..judging._identifiability import QUANTILE
from ..problem._problem import Problem, factorise
from ..problem._target import CheckedTarget
from ..problem._whole_pictures import whole_rows
from ..problem._within import within_pixels
from ._estimating import bends_of

ROUNDS = 3
"""The cells' constraints are linear near a point, which they move: so often."""
EDGE = 0.25
"""Share of a cell: a pixel whose samples vary by more, beyond a smooth course, has an edge in it and says nothing."""
FAR = 30.0
"""So many standard errors of least squares from its answer, the constraints are no longer linear."""
FURTHEST = 200.0
"""The cells are looked through for this many standard errors of least squares about its answer."""


@dataclass(frozen=True)
class ByCodes:
    """What the codes say; see `_codes`."""

    values: np.ndarray
    error: np.ndarray
    """Standard errors, (p,)."""
    ends: np.ndarray | None
    """Certain bounds, (p, 2); None where there is noise before rounding."""
    noise: float
    """Before rounding; 0 where the codes need none."""
    factor: np.ndarray
    films: tuple[np.ndarray, ...]
    standard: tuple[np.ndarray, ...] | None
    """What is left over, in units of its deviation, (height, width, 3) for each target; None where nothing is."""


def by_codes(
    problem: Problem,
    targets: Sequence[CheckedTarget],
    values: np.ndarray,
    films: Sequence[np.ndarray],
    error: np.ndarray,
    deviations: Sequence[np.ndarray],
) -> ByCodes | None:
    """From the solution of least squares, what it renders, and its standard errors; None where the codes say no more
    than that. `deviations` that residuals have shown, (height, width, 3).
    """
    files = [t.file for t in targets if t.noise is None and t.file is not None and t.file.clipped is not None]
    if len(files) < len(targets) or any(file.cells is None for file in files):
        return None
    if not np.isfinite(error).all() or not (error > 0).all():
        return None
    low, high = np.asarray([u.bounds for u in problem.unknowns], np.float64).T
    size, start = np.minimum(FURTHEST * error, high - low), values
    ends, found, edges = None, None, _edges(problem, targets, values, films)
    for _ in range(ROUNDS):
        cells, used = _cells(problem, targets, values)
        keep = np.concatenate([~edge[where] for edge, where in zip(edges, used, strict=True)])
        uneven = np.concatenate([d[where] for d, where in zip(deviations, used, strict=True)])
        # What residuals have shown beyond the rounding of codes and what is usual is the model's: edges.
        excess = uneven**2 - cells.width**2 / 12
        doubtful = replace(cells, slack=np.sqrt(cells.slack**2 + np.maximum(excess - np.median(excess), 0)))
        certain = _certain(cells, keep, size)
        if certain is not None:
            ends, found = values[:, None] + certain, None
            middle = np.clip(ends.mean(axis=1), low, high)
            change = middle - values
        else:
            ends, found = None, most_likely(doubtful, [np.ones(len(keep)), cells.width])
            change = np.clip(values + found.change, low, high) - values
        values = values + change
        if not np.all(abs(values - start) < FAR * error):
            return None
        if np.all(abs(change) < 0.02 * error):
            break
    whole_factor, films = factorise(problem, values)
    factor = whole_factor[:-1, :-1]
    if ends is not None:
        ends = np.clip(ends, low[:, None], high[:, None])
        # A bound that the search itself set is none.
        if np.any(ends[:, 1] - ends[:, 0] > 1.9 * size):
            return None
        return ByCodes(values, (ends[:, 1] - ends[:, 0]) / 2 / QUANTILE, ends, 0.0, factor, films, None)
    assert found is not None
    cells, used = _cells(problem, targets, values)
    standard, first = [], 0
    z = standardised(cells, found.sigma)
    for where, edge in zip(used, edges, strict=True):
        picture, count = np.zeros(where.shape), int(where.sum())
        picture[where] = z[first : first + count]
        standard.append(np.where(edge, 0, picture))
        first += count
    error = np.sqrt(np.maximum(np.diagonal(found.covariance), 0))
    if not np.all(error < (high - low) / 2):
        return None
    return ByCodes(values, error, None, float(np.median(found.sigma)), factor, films, tuple(standard))


def _certain(cells: Cells, keep: np.ndarray, size: np.ndarray) -> np.ndarray | None:
    """Certain bounds by all pixels or, where they allow nothing, by those without an edge."""
    found = bounds_of_polytope(cells, size)
    if found is not None or keep.all() or keep.sum() < len(keep) / 2:
        return found
    return bounds_of_polytope(_some(cells, keep), size)


def _some(cells: Cells, keep: np.ndarray) -> Cells:
    """The cells of some rows."""
    return Cells(
        *(array[keep] for array in (cells.jacobian, cells.middle, cells.low, cells.high, cells.slack, cells.weight))
    )


def _edges(
    problem: Problem, targets: Sequence[CheckedTarget], values: np.ndarray, films: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """Which values, (height, width, 3), have an edge within their pixel."""
    found = []
    within_all = within_pixels(problem, values)
    for view, target, within, film in zip(problem.views, targets, within_all, films, strict=True):
        rough = within if within.any() else bends_of(np.asarray(view.picture(film), np.float64))
        assert target.file is not None and target.file.step is not None, "asked for by `by_codes`"
        step = target.file.step
        found.append(np.sqrt(rough) > EDGE * step if within.any() else np.sqrt(rough) > 8 * step)
    return found


def _cells(problem: Problem, targets: Sequence[CheckedTarget], values: np.ndarray) -> tuple[Cells, list[np.ndarray]]:
    """The rows of all pixels that count, and which these are in each target, (height, width, 3)."""
    eps = float(np.finfo(problem.scene.dtype).eps)
    jacobians, middles, lows, highs, weights, used = [], [], [], [], [], []
    for rows, target in zip(whole_rows(problem, values), targets, strict=True):
        where = np.broadcast_to((target.mask > 0)[..., None], rows.shown.shape)
        columns = rows.columns.transpose(0, 1, 3, 2)[where].astype(np.float64)
        jacobian = columns / rows.view.weight[where][:, None]
        assert target.file is not None and target.file.cells is not None, "asked for by `by_codes`"
        low, high = target.file.cells
        jacobians.append(problem.joined(jacobian.T, rows.numbers).T)
        middles.append(rows.shown[where])
        lows.append(low[where])
        highs.append(high[where])
        weights.append(np.full(len(jacobian), target.channels / 3))
        used.append(where)
    middle = np.concatenate(middles)
    slack = 2 * eps * np.maximum(np.abs(middle), 1e-3)
    return (
        Cells(
            np.concatenate(jacobians), middle, np.concatenate(lows), np.concatenate(highs), slack,
            np.concatenate(weights),
        ),
        used,
    )  # fmt: skip
