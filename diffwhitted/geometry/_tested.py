"""How many boxes and surfaces a search tests for each ray: the same walk once more, with a tally.

The walk in JAX and the machine code go through the same nodes in the same order, so one count is that of both.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..numerics._vector import lookup
from ._asking import Asked, entry
from ._boxes import BoxTree
from ._ray import Departure, Ray
from ._search import Shapes
from ._walk import walk


class Tested(eqx.Module):
    """Tests a ray."""

    boxes: Int[Array, "n"]
    """Of the tree: the root, and both children of each node that is looked into."""
    surfaces: Int[Array, "n"]
    """Those in the leaves that are come to; all of a family that is asked one by one."""

    def __add__(self, other: "Tested") -> "Tested":
        return Tested(self.boxes + other.boxes, self.surfaces + other.surfaces)


def tested_for_nearest(shapes: Shapes, ray: Ray, departure: Departure, there: Bool[Array, "n"]) -> Tested:
    """What `nearest` tests for the rays that are `there`; 0 for others."""

    def closer(asked: Asked, best, k, member, _):
        return jnp.minimum(best, member.first_crossing(*asked.start(k))[0])

    limit = jnp.where(there, jnp.inf, 0).astype(ray.origin.dtype)
    return _over(shapes, ray, departure, limit, limit, closer, lambda _, best: best, None)


def tested_for_blocked(shapes: Shapes, ray: Ray, departure: Departure, limit, blocks) -> Tested:
    """What `blocked` tests for the rays whose `limit` is above 0; 0 for others."""

    def either(asked: Asked, found, k, member, flags):
        hit = member.first_crossing(*asked.start(k))[0] < asked.limit
        return found | (hit if flags is None else hit & flags[k])

    no = jnp.zeros(ray.origin.shape, bool)
    return _over(shapes, ray, departure, limit, no, either, lambda asked, _: asked.limit, lambda found: found, blocks)


def tested_for_counts(shapes: Shapes, ray: Ray, departure: Departure, limit) -> Tested:
    """What `crossing_counts` tests for the rays whose `limit` is above 0; 0 for others."""
    no = jnp.zeros(ray.origin.shape, bool)
    return _over(shapes, ray, departure, limit, no, lambda _, found, *a: found, lambda asked, _: asked.limit, None)


def _over(
    shapes: Shapes,
    ray: Ray,
    departure: Departure,
    limit,
    found,
    meet: Callable,
    end: Callable,
    content: Callable | None,
    flags=None,
) -> Tested:
    """The tests of all families; `flags`: one a surface, for `meet`."""
    none = jnp.zeros(ray.origin.shape, jnp.int32)
    total = Tested(none, none)
    for first, family, boxes in shapes.searched():
        if boxes is None:
            total = total + Tested(none, jnp.where(limit > 0, family.count, 0))
        else:
            asked = Asked(ray, departure.counted_from(first, shapes.sheets), limit)
            mine = shapes.part(flags, first, family)
            total = total + _walked(family, boxes, asked, found, lambda *a, mine=mine: meet(*a, mine), end, content)
    return total


def _walked(
    family: Any, boxes: BoxTree, asked: Asked, found, meet: Callable, end: Callable, content: Callable | None
) -> Tested:
    """The tests of one tree."""
    # What belongs to surfaces, not to rays, stays behind.
    sheet_of = asked.departure.sheet_of
    bare = replace(asked, departure=replace(asked.departure, sheet_of=None))

    def enter(asked, state, low, high):
        return entry(asked, low, high, end(asked, state[0]))

    def met(asked, state, number):
        whole = replace(asked, departure=replace(asked.departure, sheet_of=sheet_of))
        return meet(whole, state[0], number, lookup(family, number)), state[1]

    def tally(state, inner, at_surface):
        found, tested = state
        return found, tested + Tested(2 * inner.astype(jnp.int32), at_surface.astype(jnp.int32))

    awake = asked.limit > 0
    begun = Tested(awake.astype(jnp.int32), jnp.zeros(awake.shape, jnp.int32))
    ended = None if content is None else lambda state: content(state[0])
    return walk(boxes, enter, met, ended, bare, (found, begun), ~awake, tally)[1]
