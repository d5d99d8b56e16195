"""The order of objects by their size, by which nested solids are told apart."""

import jax.numpy as jnp
from jaxtyping import Array, Int

from ..records import stacked


def ranked(objects) -> Int[Array, "objects"]:
    """The place of each object in the order of size; of two of one size the later one comes first."""
    if not objects:
        return jnp.zeros(0, jnp.int32)
    size = stacked([type(thing).size(thing) for thing in objects])  # a bound method takes long to make
    order = jnp.lexsort((-jnp.arange(len(objects)), size))
    return jnp.zeros(len(objects), jnp.int32).at[order].set(jnp.arange(len(objects), dtype=jnp.int32))
