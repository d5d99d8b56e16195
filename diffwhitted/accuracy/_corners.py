"""Samples of some pixels of a picture, so many places in each of them as a pixel has."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..numerics._kept import kept
from ..scene import AbstractCamera, Tables
from ..tree import Beyond, Plan, Samples, sample_places, trace, trace_left_out

MOST_PLACES = 64
"""Places in a pixel that one call of a program takes; more of them take several calls."""


class Corners(eqx.Module):
    """The upper left corners of the pixels of a pass, in pixels."""

    column: Float[Array, "n"]
    row: Float[Array, "n"]
    there: Array
    number: Int[Array, "n"]
    """Of the place in its pixel that each is, where it is one."""


Places = tuple[Float[Array, "most 2"], Int[Array, ""], Int[Array, ""], Int[Array, ""]]
"""Places in a pixel, how many of them count, the number of the first, and how many the pixel has in all."""


def places_in_pixel(side: int) -> np.ndarray:
    return np.asarray(sample_places(side, np.float32), np.float64)


def place_groups(side: int, dtype) -> list[Places]:
    """The middles of side x side squares of a pixel, so many at a time as a program takes."""
    places = places_in_pixel(side).astype(dtype)
    groups = np.pad(places, ((0, -len(places) % MOST_PLACES), (0, 0))).reshape(-1, MOST_PLACES, 2)
    return [
        (
            jnp.asarray(group),
            jnp.int32(min(MOST_PLACES, len(places) - MOST_PLACES * n)),
            jnp.int32(MOST_PLACES * n),
            jnp.int32(len(places)),
        )
        for n, group in enumerate(groups)
    ]


def dealt(plan: Plan, column: np.ndarray, row: np.ndarray, number: np.ndarray, count: int) -> list[Corners]:
    """The corners dealt to `count` passes, every so many-th to the same."""
    room = count * plan.pass_pixels - len(column)
    column, row, number = (np.pad(at, (0, room), mode="edge").reshape(-1, count).T for at in (column, row, number))
    there = (np.arange(count * plan.pass_pixels) < len(column.T) * count - room).reshape(-1, count).T
    return [Corners(*map(jnp.asarray, corners)) for corners in zip(column, row, there, number, strict=True)]


@kept
def corner_pass(
    tables: Tables,
    camera: AbstractCamera,
    plan: Plan,
    corners: Corners,
    places,
    count,
    first,
    total,
    depth,
    side,
    beyond: Beyond | None = None,
):
    """The mean over what is left to chance, and the sum over `count` places, of the films (3, pixels); of their
    descendants, the largest number and the sum.

    The samples are those of `drawn` for all places. With `beyond` the film is of the most light that the branches that
    are not followed could bring.
    """
    tables = replace(tables, max_depth=depth)
    times = (plan.chances + total - 1) // total

    def one_sample(number, state):
        film, most, sum_of_all = state
        place, at = number // (plan.bands * times), number + first * plan.bands * times
        column, row = (corner + places[place, axis] for axis, corner in enumerate((corners.column, corners.row)))
        samples = Samples(column, row, corners.there, side, at, corners.number * times)
        if beyond is not None:
            light, descendants = trace_left_out(tables, camera, plan, samples, beyond)
        else:
            light, _, descendants = trace(tables, camera, plan, samples)
        return film + light.stacked(axis=0), jnp.maximum(most, descendants), sum_of_all + descendants

    nothing = jnp.zeros((3, plan.pass_pixels), camera.look_from.dtype), jnp.int32(0), jnp.int32(0)
    film, most, sum_of_all = jax.lax.fori_loop(0, count * plan.bands * times, one_sample, nothing)
    return film / (plan.bands * times), most, sum_of_all
