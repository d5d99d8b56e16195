"""A look along the coefficients that move rays, before a fit begins.

The loss of a refractive index has several valleys even when it is blurred. One look at each of a few places, spread
evenly in the coefficient's own scale between its bounds, tells which valley to begin in.
"""

import jax.numpy as jnp
import numpy as np

from ..problem._problem import Problem, factorise
from ..problem._unknowns import Unknown

PLACES = 10
CLEARLY = 0.7
"""A place is better than the start if its loss is below this share of the start's."""


def best_of(problem: Problem, start: np.ndarray, sigma: float) -> np.ndarray:
    """The start, or the place along its moving coefficients where the residuals, blurred by `sigma` pixels, are
    clearly smaller.
    """
    shares = (np.arange(PLACES) + 0.5) / PLACES
    best, least = start, CLEARLY * _loss(problem, start, sigma)
    for i in (i for i, unknown in enumerate(problem.unknowns) if _several_valleys(unknown)):
        along = np.asarray(problem.bounds.unknowns(jnp.asarray(best, float)))
        for share in shares:
            place = np.asarray(
                problem.bounds.values(
                    jnp.asarray(np.where(np.arange(len(along)) == i, np.arcsin(np.sqrt(share)), along))
                )
            )
            if (loss := _loss(problem, place, sigma)) < least:
                best, least = place, loss
    return best


def _several_valleys(unknown: Unknown) -> bool:
    """Is it a coefficient that moves rays? Places and sizes have one valley as far as the blur reaches."""
    return unknown.parameter.family == "material" and unknown.row.moves_rays


def _loss(problem: Problem, values: np.ndarray, sigma: float) -> float:
    factor, _ = factorise(problem, values, sigma)
    return 0.5 * float(factor[:, -1] @ factor[:, -1])
