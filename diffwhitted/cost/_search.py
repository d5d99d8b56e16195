"""What the search for surfaces costs: boxes and surfaces tested, by kind of ray."""

from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int

from ..geometry import Tested, tested_for_blocked, tested_for_counts, tested_for_nearest
from ..numerics._stage import LANES
from ..scene import AbstractCamera, Tables
from ..tree import BRANCH_NAMES, Plan, Record, arrivals, blocking, grid, sought

MOST = 2**13
"""Rays of a kind that are counted, spread over all of them."""


@dataclass(frozen=True)
class SearchCounts:
    """Tests a ray, the mean over the rays of one kind."""

    counted: int
    """So many rays; of a large picture a part of them, spread over it."""
    boxes: float
    """Boxes of trees."""
    surfaces: float
    """Spheres, triangles, ...: those in the boxes that were come to, and all of the kinds that have no tree."""


def count_tests(
    tables: Tables, camera: AbstractCamera, plan: Plan, trees: Record, counted: np.ndarray, shadows: str | None
) -> dict[str, SearchCounts]:
    """By kind of ray, and "shadow"; none where no family is searched by a tree. Kinds without a ray are left out.

    `trees`: those of all passes, recorded by `plan`; `counted`: which of their slots (passes, slots) count. The pixels
    of each pass are spread over the picture, so the first one stands for all. `shadows`: "opaque" or "tinted", None
    where none are cast. Searches for silhouettes are not counted.
    """
    if all(boxes is None for boxes in tables.shapes.boxes):
        return {}
    tree = jax.tree.map(lambda a: a[0], trees)
    arrived, kind = _arrived(tables, camera, plan, tree), np.asarray(tree.nodes.origin.branch)
    found, to_lights = {}, np.zeros(4)
    for number, name in enumerate(BRANCH_NAMES):
        slots = np.flatnonzero(counted[0] & (kind == number))
        some = slots[np.arange(min(MOST, len(slots))) * len(slots) // max(min(MOST, len(slots)), 1)]
        if not len(some):
            continue
        room = -(-len(some) // LANES) * LANES
        there = jnp.arange(room) < len(some)
        sums = _tests(tables, camera, plan, tree, arrived, jnp.asarray(np.resize(some, room)), there, shadows)
        boxes, surfaces, *more = (float(value) for value in sums)
        found[name] = SearchCounts(len(some), boxes / len(some), surfaces / len(some))
        # Of a kind that was counted in part each shadow ray stands for several.
        to_lights += [more[0], *(np.asarray(more) * (len(slots) / len(some)))]
    if to_lights[1]:
        found["shadow"] = SearchCounts(int(to_lights[0]), *map(float, to_lights[2:] / to_lights[1]))
    return found


@eqx.filter_jit
def _arrived(tables: Tables, camera: AbstractCamera, plan: Plan, tree: Record):
    return arrivals(tables, camera, plan, _samples(camera, plan), tree)


@eqx.filter_jit
def _tests(
    tables: Tables,
    camera: AbstractCamera,
    plan: Plan,
    tree: Record,
    arrived,
    slot: Int[Array, "n"],
    there: Bool[Array, "n"],
    shadows: str | None,
):
    """Boxes and surfaces that rays test; shadow rays, and the boxes and surfaces that these test."""
    shapes, none = tables.shapes, jnp.zeros(slot.shape, jnp.int32)
    ray, departure, to_lights = sought(tables, camera, plan, _samples(camera, plan), tree, arrived, slot, there)
    own, others, sent = tested_for_nearest(shapes, ray, departure, there), Tested(none, none), none
    for one in to_lights if shadows else ():
        asked = one.ray, one.departure, one.limit
        others = others + tested_for_blocked(shapes, *asked, blocking(tables) if shadows == "tinted" else None)
        others = others + tested_for_counts(shapes, *asked) if shadows == "tinted" else others
        sent = sent + (one.limit > 0)
    return tuple(part.sum() for part in (own.boxes, own.surfaces, sent, others.boxes, others.surfaces))


def _samples(camera: AbstractCamera, plan: Plan):
    return grid(plan, camera, jnp.int32(0), jnp.full(2, 0.5, camera.look_from.dtype))
