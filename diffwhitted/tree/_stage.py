"""Stages: pieces of work whose results are written out once.

XLA on a CPU repeats cheap arithmetic in every place that uses its result, so a long chain of vector algebra
with many results grows by the product of its stages (measured on the record of three spheres: three times
the run time). A branch of `lax.cond` is a boundary that this repetition cannot cross.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int


def stage(needed: Bool[Array, ""], work: Callable, *operands):
    """`work(*operands)`, computed as one stage; zeros where it is not `needed`."""

    def nothing(*operands):
        return jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), jax.eval_shape(lambda *a: work(*a), *operands))

    return jax.lax.cond(needed, lambda *a: work(*a), nothing, *operands)


def empty_buffers(shapes, length: int):
    """Arrays of zeros of this length, one for each array in `shapes`."""
    return jax.tree.map(lambda s: jnp.zeros(length, s.dtype), shapes)


def write_block(buffers, block, start: Int[Array, ""]):
    """The buffers with the block written from `start` on, in place where XLA may."""
    return jax.tree.map(lambda all, new: jax.lax.dynamic_update_slice_in_dim(all, new, start, 0), buffers, block)


def read_block(buffers, start: Int[Array, ""], length: int):
    """The block of this length that begins at `start`."""
    return jax.tree.map(lambda all: jax.lax.dynamic_slice_in_dim(all, start, length), buffers)
