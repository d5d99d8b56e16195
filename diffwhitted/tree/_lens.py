"""Where the camera rays of a sample leave the lens (Cook et al. 1984, section 3.3)."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..scene import Tables
from ._arrival import Origin
from ._chance import IN_CAMERAS, chances, mixed, places
from ._plan import Plan
from ._samples import Samples


def on_lens(tables: Tables, plan: Plan, samples: Samples, origin: Origin):
    """A place in the unit disc for each camera ray.

    Every other sample is the opposite of the one before, so that what is linear in the place has its mean exactly: the
    derivative in the aperture is of the second order where the aperture is small, and would drown in the first.
    """
    column, row, level, number = chances(plan, samples, origin, jnp.zeros_like(origin.level))
    right, up = _in_disc(
        *places(mixed(tables.seed, column, row, level), number // 2, IN_CAMERAS[:2], samples.column.dtype)
    )
    sign = jnp.where(number % 2 == 1, -1, 1).astype(right.dtype)
    return sign * right, sign * up


def _in_disc(u: Float[Array, "*n"], v: Float[Array, "*n"]) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
    """Even places in the unit disc from even places in the unit square."""
    radius, angle = jnp.sqrt(u), 2 * jnp.pi * v
    return radius * jnp.cos(angle), radius * jnp.sin(angle)
