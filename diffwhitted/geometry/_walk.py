"""Rays that walk through a tree of boxes, each at its own pace, without a stack.

A ray goes down to the nearer of two boxes that it meets and remembers the other one by a bit: the bits of the levels
where a box is still to be seen are all that it carries ("Dynamic Stackless Binary Tree Traversal", Barringer and
Akenine-Moeller, JCGT 2013). Rays walk side by side in `LANES_AT_ONCE` lanes; a lane whose ray has finished takes the
next ray after a few steps, so that a long walk holds up only its own lane.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..numerics._vector import Vec3, where
from ._boxes import ROW, BoxTree

LANES_AT_ONCE = 4096
STEPS = 16
"""Between two looks for lanes that have finished."""


class _Lanes(eqx.Module):
    """One ray a lane."""

    ray: Int[Array, "lanes"]
    """Its number; that of no ray where none is left."""
    node: Int[Array, "lanes"]
    """Where it is; 0: at the end."""
    pending: Int[Array, "lanes"]
    """Bit k: the sibling of the node k levels above is still to be seen."""
    asked: object
    found: object


def walk(
    boxes: BoxTree,
    enter: Callable,
    meet: Callable,
    content: Callable | None,
    asked,
    found,
    idle: Bool[Array, "n"],
    tally: Callable | None = None,
):
    """What rays find in a tree: `found`, continued over the surfaces whose boxes they meet.

    `asked` and `found` are pytrees of arrays over the rays, the questions and the answers so far.
    `enter(asked, found, low, high)` is the distance at which a ray meets a box, infinity where it does not or need not;
    `meet(asked, found, number)` the answer after a surface; `content(found)` whether a ray need not go on; `idle`: rays
    that ask nothing; `tally(found, inner, surface)`: the answer after a step that looked into both children of a node,
    or met a surface, where steps are counted.
    """
    # List the rays that meet the box around all.
    count = idle.shape[0]
    awake = ~idle & jnp.isfinite(enter(asked, found, *_box(boxes.rows, jnp.ones(count, jnp.int32))))
    place = jnp.cumsum(awake.astype(jnp.int32))
    walkers = jnp.full(count, count, jnp.int32)
    walkers = walkers.at[jnp.where(awake, place - 1, count)].set(jnp.arange(count, dtype=jnp.int32), mode="drop")
    total, lanes = place[-1], min(LANES_AT_ONCE, count)

    def begun(turn) -> _Lanes:
        """Lanes at the root, each with the ray whose turn it is."""
        there = turn < total
        ray = walkers[jnp.where(there, turn, 0)]
        at = jnp.where(there, ray, 0)
        mine, answer = jax.tree.map(lambda a: a[at], (asked, found))
        node = there.astype(jnp.int32)
        return _Lanes(jnp.where(there, ray, count), node, jnp.zeros_like(node), mine, answer)

    def step(_, now: _Lanes) -> _Lanes:
        node, live = now.node, now.node > 0
        at_leaf = node >= boxes.leaves
        # Meet the surface of a leaf.
        number = boxes.leaf[jnp.where(at_leaf, node - boxes.leaves, 0)]
        ahead = meet(now.asked, now.found, jnp.maximum(number, 0))
        here = live & at_leaf & (number >= 0)
        found = where(here, ahead, now.found)
        found = found if tally is None else tally(found, live & ~at_leaf, here)
        stop = jnp.zeros_like(live) if content is None else content(found)
        # Look into both children of another node.
        left = jnp.where(at_leaf | ~live, 0, 2 * node)
        one = jnp.where(at_leaf, jnp.inf, enter(now.asked, found, *_box(boxes.rows, left)))
        other = jnp.where(at_leaf, jnp.inf, enter(now.asked, found, *_box(boxes.rows, left + 1)))
        both, some = jnp.isfinite(one) & jnp.isfinite(other), jnp.isfinite(one) | jnp.isfinite(other)
        down, deeper = left + (other < one), (now.pending << 1) | both
        # Go down, or up to the sibling that is still to be seen.
        levels = jax.lax.population_count((now.pending & -now.pending) - 1)
        up = jnp.where(now.pending == 0, 0, (node >> levels) ^ 1)
        rest = jnp.where(now.pending == 0, 0, (now.pending >> levels) & ~1)
        node, pending = jnp.where(some, down, up), jnp.where(some, deeper, rest)
        return _Lanes(now.ray, jnp.where(live & ~stop, node, 0), pending, now.asked, found)

    def go_on(state):
        now, following, answers = state
        now = jax.lax.fori_loop(0, STEPS, step, now)
        # Write down the answers of rays at their end, and give their lanes to those that follow.
        done = now.node == 0
        answers = _written(answers, now.found, jnp.where(done, now.ray, count))
        turn = following + jnp.cumsum(done.astype(jnp.int32))
        return where(done, begun(jnp.where(done, turn - 1, count)), now), turn[-1], answers

    def waiting(state):
        now, following, _ = state
        return (following < total) | (now.node > 0).any()

    first = begun(jnp.arange(lanes, dtype=jnp.int32))
    return jax.lax.while_loop(waiting, go_on, (first, jnp.int32(lanes), found))[2]


def _written(answers, found, ray):
    return jax.tree.map(lambda all, mine: all.at[ray].set(mine, mode="drop"), answers, found)


def _box(rows, node) -> tuple[Vec3, Vec3]:
    """The corners of the boxes of nodes."""
    first = node * ROW
    numbers = [rows.at[first + k].get(mode="promise_in_bounds") for k in range(6)]
    return Vec3(*numbers[:3]), Vec3(*numbers[3:])
