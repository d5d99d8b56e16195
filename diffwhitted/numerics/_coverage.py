"""Averages over a pixel of functions that an edge cuts, exact where the edge is straight.

A function g that is linear over the pixel, g + g_u u + g_v v with u and v from -1/2 to 1/2, has a trapezoid for
its distribution: with hi >= lo the two of |g_u|, |g_v|, and m, n = (hi +- lo) / 2, it is flat within n of g and
falls to 0 at m. The means below follow by integration. They are smooth in g and in its slopes, so that the
derivative of a picture sees an edge move, where a sample on one side of it does not.

Edges: a slope of 0 in both directions leaves the hard decision g > 0, whose derivative is 0; `lo` is kept above a
hundredth of `hi`, where an edge that runs along the pixel's sides would make a step of the fall.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

NARROWEST = 0.01
FLATTEST = 1e-18
"""A slope below this is none, so that nothing under- or overflows."""
LEVEL = 1e-7


class Linear(eqx.Module):
    """A function of the place in a pixel, to first order: its value in the middle and its change over the pixel."""

    value: Float[Array, "*n"]
    across: Float[Array, "*n"]
    down: Float[Array, "*n"]

    def __neg__(self) -> "Linear":
        return Linear(-self.value, -self.across, -self.down)

    def __sub__(self, offset) -> "Linear":
        """The function less a constant."""
        return Linear(self.value - offset, self.across, self.down)

    def within(self, reach: float) -> "Linear":
        """The function with its slopes made smaller where it would change by more than `reach` along a side of the
        pixel.

        For what has bounds of its own, such as a cosine, where the pixel's footprint is too large to be linear.
        """
        most = jnp.maximum(abs(self.across), abs(self.down))
        scale = reach / jnp.maximum(most, reach)
        return Linear(self.value, self.across * scale, self.down * scale)

    def window(self):
        """hi and lo of the slopes."""
        a, b = abs(self.across), abs(self.down)
        high = jnp.maximum(a, b)
        return high, jnp.maximum(jnp.minimum(a, b), NARROWEST * high)


def is_cut(g: Linear, least: float) -> Bool[Array, "*n"]:
    """Does the edge g = 0 leave more than the share `least` of the pixel on either side?"""
    high, low = g.window()
    tail = _tail(g, high, low)
    return (tail > 0) & (tail * tail > 2 * least * high * low)


def coverage(g: Linear) -> Float[Array, "*n"]:
    """The share of the pixel where g > 0."""
    cut, positive, g, low = _in_slopes(g)
    flat, inside, tail = _regions(g, low)
    share = jnp.where(flat, 0.5 + inside, jnp.where(positive, 1 - tail * tail / (2 * low), tail * tail / (2 * low)))
    return jnp.where(cut, share, positive.astype(share.dtype))


def ramp(g: Linear) -> Float[Array, "*n"]:
    """The mean over the pixel of max(g, 0)."""
    value, high = g.value, g.window()[0]
    cut, positive, g, low = _in_slopes(g)
    flat, inside, tail = _regions(g, low)
    n = 0.5 * (1 - low)
    middle = low * low / 6 + 0.5 * (inside + n) + 0.5 * (inside * inside - n * n)
    beyond = tail * tail * tail / (6 * low) + jnp.where(positive, g.value, 0)
    return jnp.where(cut, high * jnp.where(flat, middle, beyond), jnp.where(positive, value, 0))


def joint_coverage(g: Linear, h: Linear) -> Float[Array, "*n"]:
    """The share of the pixel where g > 0 and h > 0: the area of the square cut by two straight edges.

    Green's theorem: half the sum over the sides of the cut square of (distance of the side from the middle,
    positive where the middle lies inside it) times its length.
    """
    g, h = (_in_slopes(f)[2] for f in (g, h))
    area = 0.25 * sum(_length_of_side(g, h, *side) for side in _SIDES)
    return area + _of_chord(g, h) + _of_chord(h, g)


_SIDES = ((0.5, None), (-0.5, None), (None, 0.5), (None, -0.5))


def _length_of_side(g: Linear, h: Linear, u, v):
    """Of one side of the pixel, the length on which both are positive."""
    low, high = -0.5, 0.5
    for f in (g, h):
        at, slope = (f.value + f.across * u, f.down) if v is None else (f.value + f.down * v, f.across)
        low, high = _clipped(low, high, at, slope)
    return jnp.maximum(high - low, 0)


def _of_chord(g: Linear, h: Linear):
    """The part of the area that belongs to the edge g = 0, within the pixel and where h > 0."""
    steepness_squared = g.across * g.across + g.down * g.down
    there = steepness_squared > 0
    steepness = jnp.sqrt(jnp.where(there, steepness_squared, 1))
    unit_u, unit_v, distance = g.across / steepness, g.down / steepness, g.value / steepness
    start_u, start_v = -distance * unit_u, -distance * unit_v
    low, high = -1.0, 1.0
    for at, slope in (
        (0.5 - start_u, unit_v),
        (0.5 + start_u, -unit_v),
        (0.5 - start_v, -unit_u),
        (0.5 + start_v, unit_u),
        (h.value + h.across * start_u + h.down * start_v, h.down * unit_u - h.across * unit_v),
    ):
        low, high = _clipped(low, high, at, slope)
    return jnp.where(there, 0.5 * distance * jnp.maximum(high - low, 0), 0)


def _clipped(low, high, at, slope):
    """The interval cut to where at + slope t > 0; a slope of less than `LEVEL` changes nothing between -1 and 1."""
    level = abs(slope) < LEVEL
    crossing = -at / jnp.where(level, 1, slope)
    low = jnp.where(~level & (slope > 0), jnp.maximum(low, crossing), low)
    high = jnp.where(~level & (slope < 0), jnp.minimum(high, crossing), jnp.where(level & (at <= 0), low, high))
    return low, high


def _in_slopes(g: Linear):
    """Whether the edge cuts the pixel, the sign, and g and lo in units of hi; harmless where it does not cut."""
    high, low = g.window()
    sloping = high > FLATTEST
    unit = jnp.where(sloping, high, 1)
    cut = sloping & (_tail(g, high, low) > 0)
    value = jnp.where(cut, g.value / unit, jnp.sign(g.value))
    across, down = (jnp.where(sloping, slope / unit, 0) for slope in (g.across, g.down))
    return cut, g.value > 0, Linear(value, across, down), jnp.where(cut, low / unit, 1)


def _regions(g: Linear, low):
    """Of a g in units of hi: is it in the flat part of the trapezoid, g there, and m - |g| outside it."""
    flat = abs(g.value) < 0.5 * (1 - low)
    return flat, jnp.where(flat, g.value, 0), jnp.maximum(_tail(g, 1, low), 0)


def _tail(g: Linear, high, low):
    return 0.5 * (high + low) - jnp.where(g.value > 0, g.value, -g.value)
