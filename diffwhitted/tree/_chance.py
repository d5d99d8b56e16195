"""What is left to chance: points of low-discrepancy sequences, moved by a number of each pixel (Cook et al. 1984).

The points hang on the seed, the pixel and the number of the sample alone, never on a number of the scene: so
derivatives are those of each ray (reparametrised).
"""

from collections.abc import Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ._arrival import Origin
from ._plan import Plan
from ._samples import Samples

LEVELS = 128
"""More than a tree has."""
ON_SURFACES = 0.7548776662466927, 0.5698402909980532
"""Steps of Roberts' sequence R2: 1/g and 1/g**2 with g**3 = g + 1, as even in the plane as the golden ratio is on a
line.
"""
IN_CAMERAS = 0.8191725133961645, 0.6710436067037893, 0.5497004779019703
"""Steps of R3: 1/g, 1/g**2 and 1/g**3 with g**4 = g + 1, of another field, so that both together are even too."""

IN_TIME = (0.6180339887498949,)
"""The golden ratio, of a third field."""


def chances(plan: Plan, samples: Samples, origin: Origin, level: Int[Array, "n"]) -> tuple[Int[Array, "n"], ...]:
    """What decides on the chance of each ray at a level of its tree, 0 the camera's: column and row of its pixel,
    level, and number of the sample.
    """
    column, row = (at[origin.sample].astype(jnp.int32) for at in (samples.column, samples.row))
    level = level.astype(jnp.int32)
    if samples.place is not None:
        level = level + LEVELS * samples.place[origin.sample]
    return column, row, level, jnp.broadcast_to(samples.draw // plan.bands, column.shape)


def places(
    start: Int[Array, "n"], number: Int[Array, "n"], steps: Sequence[float], dtype
) -> tuple[Float[Array, "n"], ...]:
    """Numbers between 0 and 1, both excluded, one for each step: the point `number` of the sequence, moved by a number
    of 32 bits.
    """
    found = []
    for step in steps:
        # Whole numbers of 32 bits, whose overflow is the fraction.
        place = start + (number.astype(jnp.uint32) + 1) * jnp.uint32(round(step * 2**32))
        found.append((place >> 9).astype(dtype) * 2.0**-23 + 2.0**-24)
        start = mixed(start)
    return tuple(found)


def mixed(*numbers) -> Int[Array, "n"]:
    """A number of 32 bits that hangs on each of these (the finaliser of MurmurHash3 after each)."""
    total = jnp.uint32(0x9E3779B9)
    for number in numbers:
        total = (total ^ jnp.asarray(number).astype(jnp.uint32)) * jnp.uint32(0x85EBCA6B)
        total = (total ^ (total >> 13)) * jnp.uint32(0xC2B2AE35)
        total = total ^ (total >> 16)
    return total
