"""Equirectangular maps on grids of several sizes: where a direction lies on them, and what is there.

The middle column looks along -z, columns to the right turn towards +x, the top row looks to +y (Blinn and Newell 1976,
Texture and reflection in computer generated images). Between the middles of texels it is bilinear. At each pole lies
the mean of the row next to it, in all columns, so that a map is continuous on the sphere.
"""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ...numerics._vector import Vec3, lookup
from ...records import is_traced
from ..textures._levels import level_sizes, pyramid
from ..textures._mappings import spherical
from ..textures._texture import TexturePoint

Sizes = tuple[tuple[int, int], ...]
"""Rows and columns."""
LEAST_SIZE = 32, 64
"""A map of fewer rows or columns is brought to a finer grid before it is averaged over the sphere."""


class MapLevels(eqx.Module):
    """Maps of the whole sphere, one after the other, each with a row for either pole."""

    texels: Vec3
    sizes: Sizes = eqx.field(static=True)

    def at(self, across: Float[Array, "*n"], down: Float[Array, "*n"], level: int | Int[Array, "*n"] = 0) -> Vec3:
        """What a map shows at coordinates from 0 to 1 to the right and down; differentiable in both, and in the texels.

        Edge: `across` goes round; beyond the first and last row the mean of the row is approached.
        """
        sizes, first = np.asarray(self.sizes), np.asarray(_starts(self.sizes))
        if isinstance(level, int):
            (rows, columns), start = self.sizes[level], int(first[level])
        else:
            rows, columns, start = (
                lookup(jnp.asarray(numbers, jnp.int32), level) for numbers in (sizes[:, 0], sizes[:, 1], first)
            )
        # Find the rows above and below, and the columns to the left and right.
        place = jnp.clip(jnp.where(jnp.isfinite(down), down, 0), 0, 1) * rows + 0.5
        above = jnp.clip(jnp.floor(place), 0, rows)
        fall = place - above
        fall = jnp.where(above == 0, 2 * fall - 1, jnp.where(above == rows, 2 * fall, fall))
        across = jnp.where(jnp.isfinite(across), across, 0)
        along = (across - jnp.floor(across)) * columns - 0.5
        left = jnp.floor(along)
        part, left = along - left, left.astype(jnp.int32)
        right = jnp.where(left + 1 >= columns, 0, left + 1)
        left = jnp.where(left < 0, columns - 1, left)
        # Mix the four texels.
        upper = start + above.astype(jnp.int32) * columns
        top, bottom = (
            self._texel(line + left) * (1 - part) + self._texel(line + right) * part
            for line in (upper, upper + columns)
        )
        return top * (1 - fall) + bottom * fall

    def _texel(self, number) -> Vec3:
        return Vec3(*(jnp.take(c, number, mode="clip") for c in (self.texels.x, self.texels.y, self.texels.z)))


def place_on_map(direction: Vec3, rotation_deg) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
    """Coordinates to the right and down, from 0 to 1, of directions on a map that was turned by so many degrees from -z
    to +x.

    Edge: along +y and -y the coordinate to the right is that of -z, and both derivatives are 0.
    """
    zero = jnp.zeros((3,), direction.dtype)
    turn, up = spherical({"centre": zero})[0](TexturePoint(direction, direction))
    return turn + 0.5 - rotation_deg / 360, 1 - up


def solid_angles(rows: int) -> np.ndarray:
    """The share of the sphere in each row of a map."""
    edges = np.cos(np.pi * np.arange(rows + 1) / rows)
    return (edges[:-1] - edges[1:]) / 2


def halved(texels) -> list:
    """The map on grids of half the size each, down to one texel; each texel is the mean over its part of the sphere."""
    rows, columns = texels.shape[:2]
    share = np.broadcast_to(solid_angles(rows)[:, None, None], texels.shape).astype(texels.dtype)
    sums, shares, levels, first = pyramid(texels * share), pyramid(np.ascontiguousarray(share)), [], 0
    for r, c in level_sizes(rows, columns):
        part = slice(first, first + r * c)
        levels.append((sums[part] / shares[part]).reshape(r, c, 3)[::-1])
        first += r * c
    return levels


def refined(texels):
    """The map, brought to at least `LEAST_SIZE` by linear interpolation along its rows and columns."""
    xp: Any = jnp if is_traced(texels) else np
    rows, columns = (-(-least // n) for least, n in zip(LEAST_SIZE, texels.shape[:2], strict=True))
    if rows > 1:
        texels = xp.einsum("or,rck->ock", _finer(texels.shape[0], rows, False).astype(texels.dtype), texels)
    if columns > 1:
        texels = xp.einsum("oc,rck->rok", _finer(texels.shape[1], columns, True).astype(texels.dtype), texels)
    return texels


def joined(levels: Sequence) -> tuple[Any, Sizes]:
    """Maps with a row for either pole, one after the other, (all, 3), and their sizes."""
    xp: Any = jnp if any(map(is_traced, levels)) else np
    parts = []
    for level in levels:
        poles = (xp.broadcast_to(row.mean(axis=0), (1, *row.shape)) for row in (level[0], level[-1]))
        north, south = poles
        parts.append(xp.concatenate([north, level, south]).reshape(-1, 3))
    return xp.concatenate(parts), tuple((level.shape[0], level.shape[1]) for level in levels)


def _starts(sizes: Sizes) -> list[int]:
    """Where each map begins."""
    return np.cumsum([0, *((rows + 2) * columns for rows, columns in sizes[:-1])]).tolist()


def _finer(count: int, times: int, round_: bool) -> np.ndarray:
    """The weights of `count` values at the middles of `times` as many parts, (times count, count)."""
    place = (np.arange(count * times) + 0.5) / times - 0.5
    before = np.floor(place).astype(int)
    part, both = place - before, np.stack([before, before + 1])
    both = both % count if round_ else np.clip(both, 0, count - 1)
    weights = np.zeros((count * times, count))
    for numbers, weight in zip(both, (1 - part, part), strict=True):
        np.add.at(weights, (np.arange(count * times), numbers), weight)
    return weights
