"""What the pictures determine: rank, standard errors, intervals and correlations from the Jacobian.

With J'J = R'R at the solution and noise variance s^2 the covariance is s^2 (R'R)^-1 on the directions that the
pictures determine. A coefficient whose column is zero is seen by no pixel; columns that are linearly
dependent (after scaling each to length one) belong to coefficients that cannot be told apart.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..problem._unknowns import Unknown

SHARE = 0.1
"""A coefficient belongs to an undetermined direction if its part of it is at least this."""
FAINT = 1e-3
"""Or if its part is at least this, well above rounding, and the direction changes it by a tenth, in its own size, of
what it changes that coefficient by which it changes most: what is small in the picture goes along with what is
large."""
FAINT = 1e-3
"""Or if its part is at least this, well above rounding, and along the direction it changes by `SHARE` of the share of
itself by which the one that changes most does: a small thing in the picture goes along with a large one unseen."""
QUANTILE = 1.959964
WIDEST = 12**-0.5
"""A standard error beyond this share of the bounds says no more than the bounds themselves."""


@dataclass(frozen=True)
class Uncertainty:
    """By unknown: standard error (NaN where not determined), 95 % interval, and what it is confounded with."""

    spread: np.ndarray
    """Standard error along the directions that are determined, for every unknown; NaN without a noise."""
    standard_error: np.ndarray
    interval: np.ndarray
    seen: np.ndarray
    identifiable: np.ndarray
    confounded: tuple[tuple[int, ...], ...]
    correlation: np.ndarray
    rank: int

    def replaced(self, error: np.ndarray, ends: np.ndarray | None, values: np.ndarray, unknowns) -> "Uncertainty":
        """The same with other standard errors and intervals: those of the errors, or certain ends, (p, 2)."""
        error = np.where(self.identifiable, error, np.nan)
        interval = _intervals(values, error, unknowns) if ends is None else ends
        return replace(self, standard_error=error, interval=interval)


def uncertainty(
    factor: np.ndarray,
    noise: float,
    values: np.ndarray,
    unknowns: tuple[Unknown, ...],
    precision: float,
    resolution: float = 0.0,
    shift: np.ndarray | float = 0.0,
    widened: np.ndarray | float = 0.0,
) -> Uncertainty:
    """From R of the residuals' Jacobian (p, p), and the standard deviation `noise` of the residuals.

    Without a noise (NaN) there are no standard errors, and the rank alone says what is determined. `precision` is
    the relative accuracy of R: directions that are shorter than that are not determined. `resolution` is the
    share of a coefficient below which no standard error goes. `shift` is half a 95 % interval of its own, of another
    cause than noise. `widened`: standard errors where residuals are not the independent noise of the model; the larger
    one counts.
    """
    count = len(unknowns)
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    size = np.linalg.norm(factor, axis=0)
    seen = size * (high - low) > 1e-12 * max(1.0, (size * (high - low)).max(initial=0))
    scale = np.where(seen, size, 1)
    _, lengths, directions = np.linalg.svd(np.where(seen, factor / scale, 0))
    determined = lengths > precision * lengths.max(initial=1e-300)
    taking_part = _taking_part(directions, scale, values, seen, unknowns)[~determined]
    confounded = tuple(_partners(j, taking_part) for j in range(count))
    inverse = np.divide(1, lengths, out=np.zeros_like(lengths), where=determined)
    covariance = (directions.T * inverse**2) @ directions / np.outer(scale, scale) * noise**2
    spread = np.maximum(np.sqrt(np.maximum(np.diagonal(covariance), 0)), widened)
    alone = np.array([not c for c in confounded])
    identifiable = seen & alone & ~(_scaled_error(spread, values, unknowns) >= WIDEST * _scaled_width(unknowns))
    error = np.where(identifiable, np.hypot(np.maximum(spread, resolution * abs(values)), shift / QUANTILE), np.nan)
    sizes = np.where(identifiable & (spread > 0), spread, np.inf)
    correlation = np.clip(covariance / np.outer(sizes, sizes), -1, 1)
    np.fill_diagonal(correlation, 1)
    return Uncertainty(
        spread,
        error,
        _intervals(values, error, unknowns),
        seen,
        identifiable,
        confounded,
        correlation,
        int(determined.sum()),
    )


def _taking_part(
    directions: np.ndarray, scale: np.ndarray, values: np.ndarray, seen: np.ndarray, unknowns
) -> np.ndarray:
    """Which coefficients (columns) take part in which directions (rows)."""
    sizes = np.asarray(
        [max(u.size(v), 0.01 * (u.bounds[1] - u.bounds[0])) for u, v in zip(unknowns, values, strict=True)]
    )
    part = np.where(seen, np.abs(directions), 0)
    relative = part / (scale * sizes)
    largest = relative.max(axis=1, keepdims=True, initial=1e-300)
    return (part > SHARE) | ((part > FAINT) & (relative > SHARE * largest))


def _partners(j: int, taking_part: np.ndarray) -> tuple[int, ...]:
    """The other coefficients in the undetermined directions that coefficient j takes part in."""
    with_it = taking_part[taking_part[:, j]].any(axis=0)
    return tuple(int(k) for k in np.flatnonzero(with_it) if k != j)


def _intervals(values, error, unknowns) -> np.ndarray:
    """95 % intervals: symmetric in the coefficient's own scale, within the bounds of what it can be."""
    ends = np.empty((len(unknowns), 2))
    for i, u in enumerate(unknowns):
        scale = u.row.measured_in
        half, middle = QUANTILE * error[i] * scale.slope(values[i]), scale.forward(values[i])
        ends[i] = np.clip([scale.inverse(middle - half), scale.inverse(middle + half)], *u.bounds)
    return ends


def _scaled_error(error, values, unknowns) -> np.ndarray:
    """The standard error in the coefficient's own scale (value, log value, log(value - 1))."""
    return error * np.asarray([u.row.measured_in.slope(v) for u, v in zip(unknowns, values, strict=True)])


def _scaled_width(unknowns) -> np.ndarray:
    low, high = (np.asarray([u.row.measured_in.forward(u.bounds[end]) for u in unknowns]) for end in (0, 1))
    return high - low
