"""Rough surfaces: each tree of a pixel meets them with a normal of its own (Whitted 1980, section 2).

    N' = (N + s_1 T_1 + s_2 T_2) / |...|,   s_i = roughness * z_i

with Gaussian slopes in the tangent plane. The z are points of a low-discrepancy sequence through the inverse of the
normal distribution: they do not hang on the roughness, so that its derivative is that of each ray (reparametrised).
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..geometry import towards
from ..numerics._safe import normalise
from ..numerics._vector import lookup, tangents, where
from ..scene import Tables
from ._arrival import Arrival, Origin
from ._made_of import material_at
from ._plan import Plan
from ._samples import Samples

LEVELS = 128
"""More than a tree has."""
STEPS = 0.7548776662466927, 0.5698402909980532
"""Of Roberts' sequence R2: 1/g and 1/g**2 with g**3 = g + 1, as even in the plane as the golden ratio on a line."""


def chances(samples: Samples, origin: Origin, level: Int[Array, "n"]) -> tuple[Int[Array, "n"], ...]:
    """What decides on the chance of each ray at a level of its tree: column and row of its pixel, level, and sample."""
    column, row = (at[origin.sample].astype(jnp.int32) for at in (samples.column, samples.row))
    level = level.astype(jnp.int32)
    if samples.place is not None:
        level = level + LEVELS * samples.place[origin.sample]
    return column, row, level, jnp.broadcast_to(samples.draw, column.shape)


def roughened(tables: Tables, plan: Plan, at: Arrival, chance: tuple[Int[Array, "n"], ...]) -> Arrival:
    """The arrivals with the normals along which their children leave."""
    column, row, level, draw = chance
    roughness = lookup(tables.coefficients["roughness"], material_at(tables, jnp.maximum(at.object, 0)))
    first, second = _normal_pair(_mixed(tables.seed, column, row, level), draw // plan.bands, roughness.dtype)
    one, other = tangents(at.shading_normal)
    bent = normalise(at.shading_normal + one * (first * roughness) + other * (second * roughness))
    bent = towards(at.direction, bent)
    return replace(at, shading_normal=where((roughness > 0) & (at.object >= 0), bent, at.shading_normal))


def _normal_pair(start: Int[Array, "n"], number: Int[Array, "n"], dtype) -> tuple[Float[Array, "n"], ...]:
    """Two standard normal numbers: a point of the sequence, moved by a number of 32 bits.

    Every other sample is the opposite of the one before, so that what is linear in the slopes has its mean exactly:
    the derivative in the roughness is of the second order, and would drown in the first.
    """
    opposite, number = jnp.where(number % 2 == 1, -1, 1).astype(dtype), number // 2
    found = []
    for step, shift in zip(STEPS, (start, _mixed(start)), strict=True):
        # Whole numbers of 32 bits, whose overflow is the fraction.
        place = shift + (number.astype(jnp.uint32) + 1) * jnp.uint32(round(step * 2**32))
        even = (place >> 9).astype(dtype) * 2.0**-23 + 2.0**-24
        found.append(opposite * jnp.sqrt(jnp.asarray(2, dtype)) * jax.lax.erf_inv(2 * even - 1))
    return found[0], found[1]


def _mixed(*numbers) -> Int[Array, "n"]:
    """A number of 32 bits that hangs on each of these (the finaliser of MurmurHash3 after each)."""
    total = jnp.uint32(0x9E3779B9)
    for number in numbers:
        total = (total ^ jnp.asarray(number).astype(jnp.uint32)) * jnp.uint32(0x85EBCA6B)
        total = (total ^ (total >> 13)) * jnp.uint32(0xC2B2AE35)
        total = total ^ (total >> 16)
    return total
