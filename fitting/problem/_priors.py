"""What was known of coefficients before: a Gaussian for each, as one row more of the least squares.

    ((value - mean) / deviation) * noise

beside residuals whose standard deviation is `noise`, so that a prior counts for as much as it says whatever the noise
is, given or estimated.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import equinox as eqx
import numpy as np
from jaxtyping import Float

from .._errors import FitError
from ._unknowns import Unknown, are_numbers, matching

FAINT = 10.0
"""A prior weighs no less than so many times the precision of the Jacobian's columns: it determines what they do not."""


class Priors(eqx.Module):
    """By unknown; the deviation of one without a prior is infinite."""

    mean: Float[np.ndarray, "p"]
    deviation: Float[np.ndarray, "p"]
    weight: Float[np.ndarray, "p"]
    """What the distance to the mean is multiplied by."""

    def rows(self, values: np.ndarray) -> Float[np.ndarray, "p p+1"]:
        """The rows [J r]."""
        away = self.weight * (np.asarray(values, np.float64) - self.mean)
        return np.concatenate([np.diag(self.weight), away[:, None]], axis=1)

    def loss(self, values: np.ndarray) -> float:
        """Its part of |r|^2 / 2."""
        return 0.5 * float(np.sum((self.weight * (np.asarray(values, np.float64) - self.mean)) ** 2))

    def weighed(self, noise: float, factor: np.ndarray, precision: float) -> "Priors":
        """Beside residuals of this standard deviation; `factor`: R with the priors as they were."""
        gram = factor.T @ factor - np.diag(self.weight**2)
        columns, known = np.sqrt(np.maximum(np.diagonal(gram), 0)), np.isfinite(self.deviation)
        scale = np.where(columns > 0, columns, 1)
        determined = np.linalg.eigvalsh(gram / np.outer(scale, scale)).min() > precision**2
        least = 0 if determined else FAINT * precision * columns * known
        return replace(self, weight=np.maximum(noise / self.deviation, least))

    def errors(self, ways: np.ndarray, factor: np.ndarray, noise: float, precision: float) -> np.ndarray:
        """Standard errors along some ways, of residuals with this noise and the priors as they are."""
        gram = ways.T @ (factor.T @ factor - np.diag(self.weight**2)) @ ways
        told = (noise / self.deviation)[:, None] * ways
        scale = np.sqrt(np.maximum(np.diagonal(gram) + (told**2).sum(axis=0), 1e-300))
        lengths, directions = np.linalg.eigh(gram / np.outer(scale, scale))
        seen = lengths > precision**2 * max(lengths.max(initial=0), 1e-300)
        # Square roots, stacked: what only a faint prior tells is many digits below what the pictures do.
        root = np.concatenate([np.sqrt(np.where(seen, lengths, 0))[:, None] * directions.T, told / scale])
        inverse = np.linalg.pinv(root, rcond=1e-13)
        return noise * np.sqrt((inverse**2).sum(axis=1)) / scale


def priors_of(unknowns: Sequence[Unknown], noise: float) -> Priors | None:
    """Those that the unknowns have; None where none has one."""
    if not any(u.prior for u in unknowns):
        return None
    known = [u.prior or (0.0, np.inf) for u in unknowns]
    mean, deviation = np.asarray(known, np.float64).T
    return Priors(mean, deviation, noise / deviation)


def with_priors(unknowns: tuple[Unknown, ...], prior: Mapping[str, tuple[float, float]] | None) -> tuple[Unknown, ...]:
    """The unknowns with their priors, by name, with wildcards. Raises `FitError` for what is no prior."""
    known = list(unknowns)
    for pattern, given in (prior or {}).items():
        if np.shape(given) != (2,) or not are_numbers(given) or float(given[1]) <= 0:
            raise FitError(
                f"prior: {pattern} = {given!r}; allowed is (mean, standard deviation), the latter above 0; what is "
                "known for certain is written in the scene and left out of free"
            )
        for i in matching(unknowns, pattern, "prior"):
            mean, (low, high) = float(given[0]), known[i].bounds
            if not low <= mean <= high:
                raise FitError(
                    f"prior: {known[i].name} = {mean:g} is outside its bounds {low:g} to {high:g}; widen them with "
                    f"bounds={{{known[i].name!r}: (low, high)}} (--bounds {known[i].name}=LOW:HIGH)"
                )
            known[i] = replace(known[i], prior=(mean, float(given[1])))
    return tuple(known)
