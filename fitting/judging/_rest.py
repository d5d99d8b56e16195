"""Is a fit at rest? The next Gauss-Newton step, with the coefficients that a bound holds left out."""

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from diffwhitted.scene import Scene

from ..problem._target import CheckedTarget, residual_count
from ..problem._unknowns import Unknown
from ._identifiability import Uncertainty, uncertainty

AT_REST = 8.0
"""The solver stops early below so many units in the last place of the coefficient, or a 200th of the standard error."""
ON_THE_BOUND = 1e-3
"""Share of the interval within which a coefficient counts as lying on its bound."""
NEARLY = 0.01
"""Share of a coefficient (of index - 1) that a step may still be for a blurred picture to have done its part."""
HELD = 0.25
"""Share of its standard error within which a bound holds a coefficient that would go beyond it."""


def unsettled(
    values: np.ndarray,
    factor: np.ndarray,
    remainder: np.ndarray,
    known: Uncertainty,
    unknowns: tuple[Unknown, ...],
    precision: float,
    share: float,
    errors: float,
) -> np.ndarray:
    """Which coefficients the next step -R^-1 q would move by more than `share` of themselves and `errors` of their
    error.

    The step goes along the directions that the rank of R determines; whether their error is small does not matter here.
    A coefficient that the step would push through a bound close by is held there, and the step of the others
    is computed without it.
    """
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    near = np.fmax(ON_THE_BOUND * (high - low), HELD * known.standard_error)
    step = next_step(values, factor, remainder, known.seen, near, unknowns, precision)
    # What has a lowest value is small against 1; what has none, such as a place, against its interval.
    least = np.where([u.row.lowest > -np.inf for u in unknowns], np.minimum(high - low, 1), high - low)
    allowed = share * np.maximum(abs(values), 0.01 * least)
    return abs(step) > np.fmax(allowed, errors * known.spread)


def next_step(
    values: np.ndarray,
    factor: np.ndarray,
    remainder: np.ndarray,
    free: np.ndarray,
    near: np.ndarray,
    unknowns: tuple[Unknown, ...],
    precision: float,
) -> np.ndarray:
    """The step -R^-1 q along the `free` coefficients, 0 for those that it would push through a bound no further than
    `near`.
    """
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    for _ in range(len(unknowns) + 1):
        step = _step(factor, remainder, free, precision)
        held = free & (
            ((values + step < low) & (values - low < near)) | ((values + step > high) & (high - values < near))
        )
        if not held.any():
            break
        free = free & ~held
    return step


def nearly(
    values: np.ndarray, factor: np.ndarray, remainder: np.ndarray, unknowns: tuple[Unknown, ...], precision: float
) -> bool:
    """Is the next step small enough to go on with a sharper picture?"""
    sizes = np.asarray([u.size(value) for u, value in zip(unknowns, values, strict=True)])
    step = _step(factor, remainder, np.linalg.norm(factor, axis=0) > 0, precision)
    return bool(np.all(abs(step) <= NEARLY * np.maximum(sizes, NEARLY)))


def on_bound(values: np.ndarray, unknowns: tuple[Unknown, ...]) -> np.ndarray:
    """Which coefficients lie on one of their bounds."""
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    near_low = ON_THE_BOUND * np.where(low > 0, np.minimum(low, high - low), high - low)
    return (values - low < near_low) | (high - values < ON_THE_BOUND * (high - low))


def off_bound(values: np.ndarray, unknowns: tuple[Unknown, ...]) -> np.ndarray:
    """The values with those that lie on a bound a little inside, from where they may move: on a bound no unknown has
    a slope.
    """
    low, high = np.asarray([u.bounds for u in unknowns], np.float64).T
    margin = NEARLY * (high - low)
    return np.where(on_bound(values, unknowns), np.clip(values, low + margin, high - margin), values)


def _step(factor, remainder, free, precision) -> np.ndarray:
    size = np.linalg.norm(factor, axis=0)
    scale = np.where(free & (size > 0), size, 1)
    columns = np.where(free & (size > 0), factor / scale, 0)
    return -np.linalg.lstsq(columns, remainder, rcond=precision)[0] / scale


def rest_test(
    scene: Scene, targets: tuple[CheckedTarget, ...], unknowns: tuple[Unknown, ...], unit: float, errors: float = 0.005
):
    """A test for the solver: are these coefficients, with this R, q and loss, as good as they will get, or to
    `errors` of their errors?
    """

    def at_rest(values, factor, remainder, loss) -> bool:
        known = uncertainty(
            factor,
            residual_noise(targets, loss, len(unknowns), unit, scene),
            values,
            unknowns,
            jacobian_precision(scene),
        )
        return not unsettled(
            values, factor, remainder, known, unknowns, jacobian_precision(scene), rest_share(scene), errors
        ).any()

    return at_rest


def jacobian_precision(scene: Scene) -> float:
    """Relative accuracy to which the Jacobian is known."""
    return float(jnp.finfo(scene.dtype).eps) ** 0.7


def rest_share(scene: Scene) -> float:
    """Share of a coefficient below which a step does not matter to the solver."""
    return AT_REST * float(jnp.finfo(scene.dtype).eps)


def residual_noise(targets: Sequence[CheckedTarget], loss: float, unknowns: int, unit: float, scene: Scene) -> float:
    """Standard deviation of the solver's residuals, which are divided by the root of their number.

    Given with the targets, or else estimated from what is left over, and never below the rounding of the pictures.
    NaN where nothing can be left over: no more residuals than unknowns.
    """
    count = residual_count(targets)
    if targets[0].noise is not None:
        return 1 / np.sqrt(count)
    if count <= unknowns:
        return float("nan")
    brightest = max(float(np.abs(t.image).max()) for t in targets)
    rounding = float(jnp.finfo(scene.dtype).eps) * brightest / unit / np.sqrt(count)
    return float(np.hypot(np.sqrt(2 * loss / (count - unknowns)), rounding))
