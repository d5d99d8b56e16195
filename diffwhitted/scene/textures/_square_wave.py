"""The mean of a checkerboard over a footprint: square waves of +1 and -1, one an axis, multiplied.

The wave of one axis is (-1)**floor(t). Where the footprint holds at most one edge of each of two axes, the mean of
their product is that of a pixel cut by two straight edges, exactly; elsewhere the axes are taken as independent,
each with the mean of a periodic wave over a trapezoid.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...numerics._coverage import Linear, coverage, joint_coverage
from ...numerics._stage import always, stage

STRIPS = 4
STRAIGHT = 0.05
"""Slant up to which a small pixel is taken without perspective."""
WIDEST = 50.0
"""Cells; the mean over a wider footprint is 0 to three digits."""


def may_vary(waves: list[Linear], slant) -> tuple[Bool[Array, "*n"], Bool[Array, "*n"]]:
    """Where edges may lie in a pixel that is smaller than a cell and hardly in perspective, and where in any other."""
    slanted = 0.5 * (abs(slant[0]) + abs(slant[1]))
    varies, narrow = slanted > 0.9, slanted < STRAIGHT
    for wave in waves:
        reach = 0.5 * (abs(wave.across) + abs(wave.down)) / jnp.maximum(1 - slanted, 0.1)
        varies = varies | (abs(wave.value - jnp.round(wave.value)) < reach)
        narrow = narrow & _narrow(wave)
    return varies & narrow, varies & ~narrow


def cell_mean(waves: list[Linear]) -> Float[Array, "*n"]:
    """The mean of the product of the waves over a pixel that holds at most one edge of each."""
    first, *others = waves
    if not others:
        return _one_edge(first)
    product = _two_edges(first, others[0])
    for wave in others[1:]:
        product = product * _one_edge(wave)
    return product


def checker_mean(waves: list[Linear], slant) -> Float[Array, "*n"]:
    """The mean of the product of the waves, whose arguments are linear over the pixel, divided by 1 + slant_u u +
    slant_v v.

    Strip by strip, each to first order about its own middle.
    """
    waves, slant = _longer_side_down(waves, slant)
    middles = (jnp.arange(STRIPS, dtype=waves[0].value.dtype) + 0.5) / STRIPS - 0.5

    def strip(total, v):
        return total + _product([_strip(wave, slant, v) for wave in waves]), None

    return jax.lax.scan(strip, jnp.zeros_like(waves[0].value), middles)[0] / STRIPS


def _longer_side_down(waves: list[Linear], slant):
    """The same with the sides of the pixel exchanged where the arguments change more across than down."""
    across, down = (sum(abs(getattr(w, side)) for w in waves) for side in ("across", "down"))
    turn = across > down

    def turned(a, b):
        return jnp.where(turn, b, a), jnp.where(turn, a, b)

    return [Linear(w.value, *turned(w.across, w.down)) for w in waves], turned(*slant)


def _strip(wave: Linear, slant, v) -> Linear:
    """The strip at height v of the pixel, to first order about its own middle."""
    nearness = 1 / (1 + slant[1] * v)
    moved = wave.down * (v * nearness)
    return Linear(
        wave.value + moved, (wave.across - moved * slant[0]) * nearness, wave.down * nearness * nearness / STRIPS
    )


def _product(waves: list[Linear]) -> Float[Array, "*n"]:
    """The mean of the product over a strip."""
    first, *others = waves
    product = _wave(first)
    for wave in others:
        product = product * _wave(wave)
    if others:
        product = jnp.where(_narrow(first) & _narrow(others[0]), cell_mean(waves), product)
    return product


def _wave(t: Linear) -> Float[Array, "*n"]:
    """The mean of (-1)**floor(t)."""
    narrow = _narrow(t)
    return jnp.where(narrow, _one_edge(t), _periodic(t, narrow))


def _one_edge(t: Linear) -> Float[Array, "*n"]:
    """The mean of a wave with at most one edge in the footprint."""
    edge, sign = _nearest_edge(t)
    return sign * (2 * coverage(edge) - 1)


def _two_edges(s: Linear, t: Linear) -> Float[Array, "*n"]:
    """The mean of the product of two waves, each with at most one edge in the footprint."""
    (g, sign_g), (h, sign_h) = _nearest_edge(s), _nearest_edge(t)
    here = always(sign_g)
    both = stage(here, joint_coverage, g, h)
    return sign_g * sign_h * (4 * both - 2 * stage(here, coverage, g) - 2 * stage(here, coverage, h) + 1)


def _narrow(t: Linear):
    high, low = t.window()
    return high + low < 1


def _nearest_edge(t: Linear) -> tuple[Linear, Float[Array, "*n"]]:
    """The distance past the nearest edge, and the wave's sign after it."""
    edge = jnp.round(t.value)
    return t - edge, _sign(edge)


def _periodic(t: Linear, narrow) -> Float[Array, "*n"]:
    """[S(t + m) - S(t + n) - S(t - n) + S(t - m)] / (hi lo), with S'' = (-1)**floor(t) and S periodic."""
    high, low = t.window()
    wide = ~narrow & (high < WIDEST)
    high, low = jnp.where(wide, high, 1), jnp.where(wide, low, 1)
    m, n = 0.5 * (high + low), 0.5 * (high - low)
    middle = jnp.where(wide, t.value, 0)
    total = (
        _twice_integrated(middle + m)
        - _twice_integrated(middle + n)
        - _twice_integrated(middle - n)
        + _twice_integrated(middle - m)
    )
    return jnp.where(wide, total / (high * low), 0)


def _twice_integrated(t):
    whole = jnp.floor(t)
    part = t - whole
    return _sign(whole) * 0.5 * (part * part - part)


def _sign(whole):
    """(-1)**whole."""
    return 1 - 2 * (whole - 2 * jnp.floor(whole / 2))
