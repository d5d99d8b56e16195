"""Samples anywhere in the picture: packed into passes, traced, and in their order again."""

from collections.abc import Callable
from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from .._errors import CapacityError
from ..numerics._workers import processors, side_by_side
from ..tree import Plan, Samples


def traced_list(
    program: Callable[[Samples], tuple], plan: Plan, column: np.ndarray, row: np.ndarray, side: float, dtype
) -> tuple[np.ndarray, int]:
    """The film (..., n) at n places of the picture, each for a square of `side` pixels, and the rays that it took.

    `program(samples)` gives the film of one pass (..., plan.pass_pixels) and its number of descendants.
    """
    count, most = column.size, plan.pass_pixels
    passes = -(-count // most)
    if passes < processors() and count >= 2 * plan.block:
        passes = min(processors(), count // plan.block)
    each = -(-count // passes)
    films, rays = zip(
        *side_by_side(
            lambda samples: film_of(program, plan, samples),
            [packed_pass(plan, column[i : i + each], row[i : i + each], side, dtype) for i in range(0, count, each)],
        ),
        strict=True,
    )
    return np.concatenate([film[..., :each] for film in films], axis=-1)[..., :count], sum(rays)


def film_of(program: Callable[[Samples], tuple], plan: Plan, samples: Samples) -> tuple[np.ndarray, int]:
    """The film of one pass and its rays, in two halves where its tree is larger than the plan's room: no program is
    compiled for more.
    """
    film, descendants = program(samples)
    count = int(samples.there.sum())
    if int(descendants) <= plan.capacity:
        return np.asarray(film), count + int(descendants)
    if count < 2:
        raise CapacityError(f"the tree of one ray needs more room than {plan.capacity} rays; lower max_depth")
    first = jnp.cumsum(samples.there) <= count // 2
    (one, rays), (other, more) = (
        film_of(program, plan, replace(samples, there=samples.there & half)) for half in (first, ~first)
    )
    return one + other, rays + more


def packed_pass(plan: Plan, column: np.ndarray, row: np.ndarray, side: float, dtype) -> Samples:
    """One pass of these samples, and no ray in the rest of its room."""
    room = plan.pass_pixels - column.size
    columns, rows = (jnp.asarray(np.pad(a, (0, room), mode="edge"), dtype) for a in (column, row))
    return Samples(
        columns, rows, jnp.arange(plan.pass_pixels) < plan.pass_pixels - room, jnp.asarray(side, dtype), jnp.int32(0)
    )
