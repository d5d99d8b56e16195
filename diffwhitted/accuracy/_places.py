"""Where in their pixels rays are traced, dealt to passes."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..tree import Plan, sample_places

MOST_PLACES = 64
"""Places in a pixel that one call of a program takes; more of them take several calls."""


class Corners(eqx.Module):
    """The upper left corners of the pixels of a pass, in pixels."""

    column: Float[Array, "n"]
    row: Float[Array, "n"]
    there: Array
    place: Int[Array, "n"]
    """The number in the pixel of the first place that is looked at."""


Places = tuple[Float[Array, "most 2"], Int[Array, ""], Int[Array, ""]]
"""Places in a pixel, how many of them count, and the number of the first."""


def middles(side: int) -> np.ndarray:
    return np.asarray(sample_places(side, np.float32), np.float64)


def place_groups(side: int, dtype) -> list[Places]:
    """The middles of side x side squares of a pixel, so many at a time as a program takes."""
    places = middles(side).astype(dtype)
    groups = np.pad(places, ((0, -len(places) % MOST_PLACES), (0, 0))).reshape(-1, MOST_PLACES, 2)
    return [
        (jnp.asarray(group), jnp.int32(min(MOST_PLACES, len(places) - MOST_PLACES * n)), jnp.int32(MOST_PLACES * n))
        for n, group in enumerate(groups)
    ]


def dealt(plan: Plan, column: np.ndarray, row: np.ndarray, count: int, place=None) -> list[Corners]:
    """The corners dealt to `count` passes, every so many-th to the same."""
    room = count * plan.pass_pixels - len(column)
    place = np.zeros(len(column), np.int32) if place is None else place
    column, row, place = (np.pad(at, (0, room), mode="edge").reshape(-1, count).T for at in (column, row, place))
    there = (np.arange(count * plan.pass_pixels) < len(column.T) * count - room).reshape(-1, count).T
    return [Corners(*map(jnp.asarray, corners)) for corners in zip(column, row, there, place, strict=True)]
