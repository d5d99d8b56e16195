"""Reverse mode of a recorded tree, by hand: the blocks once more, from the last one to the first.

The state of the tree is known from the way there, so nothing else is kept for the way back, and both follow the blocks
that exist. What a ray gets from its children stands at its place by the time that it is visited.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero

from ..numerics._stage import read_block
from ..numerics._vector import Vec3
from ..scene import coefficients
from ._plan import Plan
from ._record import Record
from ._retrace import Given, State, block_of, blocks_there, masked, parents_of, visit


@dataclass(frozen=True)
class Varied:
    """Which of the arrays that a tree depends on have a derivative at all."""

    structure: Any
    numbers: tuple[int, ...]
    """Of the leaves of `Given`."""
    rays_move: bool

    @staticmethod
    def by(plan: Plan, tangents: Given) -> tuple["Varied", list]:
        """Those whose tangent is not a symbolic zero, and their tangents."""

        def is_zero(tangent) -> bool:
            return isinstance(tangent, SymbolicZero)

        leaves, structure = jax.tree.flatten(tangents, is_leaf=is_zero)
        tables, camera, samples = tangents
        indices = [tables.coefficients.get(row.name) for row in coefficients() if row.moves_rays]
        bending = tables.textures if plan.effects.wrinkles else ()
        moving = tables.shapes, tables.motion, indices, bending, camera, samples
        rays_move = not all(map(is_zero, jax.tree.leaves(moving, is_leaf=is_zero)))
        numbers = tuple(n for n, leaf in enumerate(leaves) if not is_zero(leaf))
        return Varied(structure, numbers, rays_move), [leaves[n] for n in numbers]

    def values(self, given: Given) -> list:
        """The arrays themselves."""
        leaves = jax.tree.leaves(given)
        return [leaves[n] for n in self.numbers]

    def replaced(self, given: Given, values: list) -> Given:
        """All of them, with `values` in place of those that are varied."""
        leaves = jax.tree.leaves(given)
        for number, value in zip(self.numbers, values, strict=True):
            leaves[number] = value
        return jax.tree.unflatten(self.structure, leaves)


def pulled_back(
    light_of: Callable, plan: Plan, varied: Varied, given: Given, record: Record, state: State, film: Vec3
) -> list:
    """The cotangents of the varied arrays from that of the film."""
    count = blocks_there(record)
    # What may have a derivative: the throughput and, where rays move, how they arrive.
    part = partial(eqx.partition, filter_spec=state and (eqx.is_inexact_array if varied.rays_move else False, True))

    def reverse_block(step, carry):
        total, of_state = carry
        start, nodes, alive = block_of(plan, given[-1], record, count - 1 - step)
        moving, still = part(parents_of(nodes, state))

        # Visit the block again, as a function of what is varied and of what it takes from its parents.
        def revisit(values, moving):
            added, here = visit(
                light_of, plan, varied.replaced(given, values), nodes, eqx.combine(moving, still), alive
            )
            return added, part(here)[0]

        _, pull = jax.vjp(revisit, varied.values(given), moving)

        # Collect what the film and its children want of it, and hand it to what is varied and to its parents.
        wanted = jax.tree.map(lambda f: f[nodes.origin.sample], film), read_block(of_state, start, plan.block)
        of_values, of_parents = pull(masked(alive, wanted))
        inner = alive & (nodes.origin.lineage != 0)
        of_parents = masked(inner, of_parents)
        of_state = jax.tree.map(lambda all, some: all.at[nodes.origin.parent].add(some), of_state, of_parents)
        return jax.tree.map(jnp.add, total, of_values), of_state

    first = jax.tree.map(jnp.zeros_like, (varied.values(given), part(state)[0]))
    return jax.lax.fori_loop(0, count, reverse_block, first)[0]
