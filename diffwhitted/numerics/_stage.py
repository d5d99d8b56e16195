"""Stages: pieces of work whose results are written out once.

XLA on a CPU repeats cheap arithmetic in every place that uses its result, so a long chain of vector algebra
with many results grows by the product of its stages (measured on the record of three spheres: three times
the run time). A branch of `lax.cond` is a boundary that this repetition cannot cross.

A stage may be for few rays only: `packed` gathers those, so that what is dear and rare costs little.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

LANES = 64
"""Every block is a multiple of this many rays."""
PACKET = 512
UNROLLED = 8
"""A loop of no more steps is written out."""


def stage(needed: Bool[Array, ""], work: Callable, *operands):
    """`work(*operands)`, computed as one stage; zeros where it is not `needed`."""

    traced_once = jax.jit(lambda *a: work(*a))  # for the shapes of its results and for the results

    def nothing(*operands):
        return jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), jax.eval_shape(traced_once, *operands))

    return jax.lax.cond(needed, traced_once, nothing, *operands)


def always(a) -> Bool[Array, ""]:
    """True, for NaN and every integer too, in a form that XLA does not see through.

    A stage that is always needed has to ask for something: a condition known when the program is compiled is
    folded away, and the boundary with it.
    """
    return ~((a[0] < 0) & (a[0] > 0))


def packed(some: Bool[Array, "n"], work: Callable, rest, *operands):
    """`work(*operands)` for the rays with `some`, and `rest` for the others; work goes in packets of `PACKET` rays.

    `work` must treat each ray by itself; its results have the structure of `rest`.
    """
    count, size = some.shape[0], min(PACKET, some.shape[0])
    packets = -(-count // size)
    before, total = running_count(some.astype(jnp.float32))
    who = jnp.zeros(packets * size, jnp.int32)
    who = who.at[jnp.where(some, before, who.shape[0])].set(
        jnp.arange(count, dtype=jnp.int32), mode="drop", unique_indices=True
    )

    def packet(result, start):
        def follow(result):
            mine = jax.lax.dynamic_slice_in_dim(who, start, size)
            found = work(*jax.tree.map(lambda a: a[mine], operands))
            there = jnp.where(start + jnp.arange(size) < total, mine, count)
            return jax.tree.map(lambda r, f: r.at[there].set(f, mode="drop", unique_indices=True), result, found)

        return jax.lax.cond(start < total, follow, lambda result: result, result), None

    return jax.lax.scan(packet, rest, jnp.arange(packets, dtype=jnp.int32) * size)[0]


def running_count(counts: Float[Array, "n"]) -> tuple[Int[Array, "n"], Int[Array, ""]]:
    """The sum of the small whole numbers before each one, and of all of them; n is a multiple of 64.

    Within rows of 64 it is a product with a triangular matrix: `cumsum` over all of them took XLA's CPU back
    end as long as the search for surfaces. Exact, as no sum reaches 2**24.
    """
    rows = counts.reshape(-1, LANES)
    through = rows @ jnp.triu(jnp.ones((LANES, LANES), counts.dtype))
    totals = through[:, -1]
    before = through - rows + (jnp.cumsum(totals) - totals)[:, None]
    return before.reshape(-1).astype(jnp.int32), totals.sum().astype(jnp.int32)


def repeated(count: int, step: Callable, carry, unrolled: int = UNROLLED):
    """`carry = step(k, carry)` for k = 0 .. count - 1: unrolled for a few, as a compiled loop for many."""
    if count > unrolled:
        return jax.lax.fori_loop(0, count, step, carry)
    for k in range(count):
        carry = step(k, carry)
    return carry


def empty_buffers(shapes, length: int):
    """Arrays of zeros whose last axis has this length, one for each array in `shapes`."""
    return jax.tree.map(lambda s: jnp.zeros((*s.shape[:-1], length), s.dtype), shapes)


def write_block(buffers, block, start: Int[Array, ""]):
    """The buffers with the block written from `start` on, in place where XLA may."""
    return jax.tree.map(lambda all, new: jax.lax.dynamic_update_slice_in_dim(all, new, start, -1), buffers, block)


def read_block(buffers, start: Int[Array, ""] | int, length: int):
    """The block of this length that begins at `start`."""
    return jax.tree.map(lambda all: jax.lax.dynamic_slice_in_dim(all, start, length, -1), buffers)
