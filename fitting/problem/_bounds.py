"""Bounds as a change of variable that one can see.

The solver's unknown x is any real number; the coefficient lies between its bounds:

    s = value, log(value) or log(value - 1)          (the coefficient's scale)
    t = (s - s_low) / (s_high - s_low) = sin(x)^2

so x = pi/4 is the middle of the bounds (the geometric mean for a log scale), and the forward model is never
clipped. Where a sum of coefficients has a limit, the upper bound of each is what those before it leave and those after
it need at least. Next to a bound the slope falls like the root of the distance; a logistic curve, whose slope falls
like the distance itself, left coefficients stuck there (measured). `slope` is d value / dx, by which the
Jacobian in the coefficients becomes the solver's.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from diffwhitted.records import SCALES

from ._unknowns import Unknown, sums_of

NUDGE = 1e-3
"""A start on a bound is moved inside by this share of the interval, since the slope is zero there."""


class Bounds(eqx.Module):
    """The change of variable for all unknowns of a fit."""

    low: Float[Array, "p"]
    high: Float[Array, "p"]
    scales: tuple[str, ...] = eqx.field(static=True)
    sums: tuple[tuple[int, ...], ...] = eqx.field(static=True)
    """The coefficients, by number, whose sums have a limit."""
    limits: Float[Array, "c"]

    def __init__(self, unknowns: tuple[Unknown, ...]):
        self.scales = tuple(u.row.scale for u in unknowns)
        ends = np.asarray([u.bounds for u in unknowns], np.float64)
        self.low, self.high = jnp.asarray(ends[:, 0], float), jnp.asarray(ends[:, 1], float)
        limited = sums_of(unknowns)
        self.sums, self.limits = tuple(m for m, _ in limited), jnp.asarray([most for _, most in limited], float)

    @eqx.filter_jit
    def values(self, x: Float[Array, "p"]) -> Float[Array, "p"]:
        """Coefficients from unknowns."""
        low, high = self._scaled(self.low), self._scaled(self.high)
        shares = jnp.sin(x) ** 2
        values = self._unscaled(low + (high - low) * shares)
        for i in self._summed():
            values = values.at[i].set(self.low[i] + (self._most(values, i) - self.low[i]) * shares[i])
        return values

    @eqx.filter_jit
    def unknowns(self, values: Float[Array, "p"]) -> Float[Array, "p"]:
        """Unknowns from coefficients inside the bounds; one on a bound is nudged inside by `NUDGE`."""
        return jnp.arcsin(jnp.sqrt(jnp.clip(self.shares(values), NUDGE, 1 - NUDGE)))

    @eqx.filter_jit
    def shares(self, values: Float[Array, "p"]) -> Float[Array, "p"]:
        """How far from the lower bound (0) to the upper (1) coefficients lie, in their own scale."""
        low, high = self._scaled(self.low), self._scaled(self.high)
        shares = (self._scaled(values) - low) / (high - low)
        for i in self._summed():
            room = self._most(values, i) - self.low[i]
            share = (values[i] - self.low[i]) / jnp.where(room > 0, room, 1)
            shares = shares.at[i].set(jnp.where(room > 0, share, 1))
        return shares

    def in_unknowns(self, jacobian: np.ndarray, x: Float[Array, "p"]) -> np.ndarray:
        """A Jacobian in the coefficients (m, p) as one in the unknowns."""
        if self.sums:
            return jacobian @ np.asarray(self.slopes(x), np.float64)
        return jacobian * np.asarray(self.slope(x), np.float64)

    @eqx.filter_jit
    def slopes(self, x: Float[Array, "p"]) -> Float[Array, "p p"]:
        """The derivative of all coefficients in all unknowns, which sums tie together."""
        return jax.jacfwd(self.values)(x)

    @eqx.filter_jit
    def slope(self, x: Float[Array, "p"]) -> Float[Array, "p"]:
        """d value / dx."""
        return jax.jvp(self.values, (x,), (jnp.ones_like(x),))[1]

    def _summed(self) -> list[int]:
        return sorted({i for members in self.sums for i in members})

    def _most(self, values, i: int):
        """The upper bound of a coefficient beside those before it."""
        most = self.high[i]
        for members, limit in zip(self.sums, self.limits, strict=True):
            if i in members:
                others = sum(values[j] if j < i else self.low[j] for j in members if j != i)
                most = jnp.minimum(most, limit - others)
        return jnp.maximum(most, self.low[i])

    def _scaled(self, values):
        return jnp.stack([SCALES[name].forward(value) for value, name in zip(values, self.scales, strict=True)])

    def _unscaled(self, values):
        return jnp.stack([SCALES[name].inverse(value) for value, name in zip(values, self.scales, strict=True)])
