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
from ._arrival import Arrival
from ._chance import ON_SURFACES, mixed, places
from ._made_of import material_at
from ._plan import Plan


def roughened(tables: Tables, plan: Plan, at: Arrival, chance: tuple[Int[Array, "n"], ...]) -> Arrival:
    """The arrivals with the normals along which their children leave."""
    column, row, level, number = chance
    roughness = lookup(tables.coefficients["roughness"], material_at(tables, jnp.maximum(at.object, 0)))
    first, second = _normal_pair(mixed(tables.seed, column, row, level), number, roughness.dtype)
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
    size = opposite * jnp.sqrt(jnp.asarray(2, dtype))
    one, other = (size * jax.lax.erf_inv(2 * even - 1) for even in places(start, number, ON_SURFACES, dtype))
    return one, other
