"""Texels on levels of half the size each, and their mean over a footprint.

A pyramid (Williams 1983) has the means of the texels on coarser and coarser grids. A footprint is a grid of probes,
each a bilinear look-up on the level whose texels are as large as the probes are apart, so that a long and narrow
footprint stays narrow (as in McCormack et al. 1999, Feline), and a pixel is averaged evenly, as by supersampling.
"""

from collections.abc import Callable
from typing import Any, Literal, get_args

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ...numerics._vector import Vec3, lookup
from ...records import is_traced

Wrap = Literal["repeat", "clamp", "mirror"]
WRAPS: tuple[str, ...] = get_args(Wrap)
LARGEST_STEP = 1024.0
"""In widths of the picture; what spreads further sees the mean of it all."""
Pair = tuple[Float[Array, "*n"], Float[Array, "*n"]]


def level_sizes(height: int, width: int) -> tuple[tuple[int, int], ...]:
    """Rows and columns of every level, down to one texel."""
    sizes = [(height, width)]
    while sizes[-1] != (1, 1):
        sizes.append((max(1, sizes[-1][0] // 2), max(1, sizes[-1][1] // 2)))
    return tuple(sizes)


def pyramid(texels: Float[Array | np.ndarray, "height width 3"]) -> Float[Array | np.ndarray, "all 3"]:
    """The texels of every level, one level after the other, the lowest row (v = 0) first; linear in the texels."""
    xp: Any = jnp if is_traced(texels) else np
    level: Any = texels[::-1]
    levels = [level.reshape(-1, 3)]
    for _ in level_sizes(*texels.shape[:2])[1:]:
        level = _halved(xp, _halved(xp, level).swapaxes(0, 1)).swapaxes(0, 1)
        levels.append(level.reshape(-1, 3))
    return xp.concatenate(levels)


def _halved(xp, rows):
    """Half as many rows, each the mean of what it covers: of 2 k + 1 rows the k-th part is 2 + 1/k rows high."""
    count = rows.shape[0]
    k = count // 2
    if count == 1:
        return rows
    if count % 2 == 0:
        return 0.5 * (rows[0::2] + rows[1::2])
    part = np.arange(k, dtype=rows.dtype)[:, None, None]
    return ((k - part) * rows[0:-2:2] + k * rows[1::2] + (part + 1) * rows[2::2]) / np.asarray(count, rows.dtype)


class Levels(eqx.Module):
    """Pictures of one size on all their levels, with the one that each ray needs."""

    texels: Float[Array | np.ndarray, "pictures all 3"]
    which: Int[Array, "*n"]
    size: tuple[int, int] = eqx.field(static=True)
    wrap: Wrap = eqx.field(static=True)

    def at(self, u: Float[Array, "*n"], v: Float[Array, "*n"]) -> Vec3:
        """Bilinear interpolation of the texels; texel (row, column) stands at ((column + 1/2)/width,
        (row + 1/2)/height), rows from the lowest one up.
        """
        height, width = (np.float32(n) for n in self.size)
        return self._bilinear(u, v, height, width, self.which * self.texels.shape[1])

    def spread(self, steps: tuple[Pair, Pair]) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """How long the sides of a footprint are, in texels."""
        height, width = self.size
        across, down = ((step[0] * width) ** 2 + (step[1] * height) ** 2 for step in steps)
        return jnp.sqrt(across), jnp.sqrt(down)

    def mean(self, uv: Pair, steps: tuple[Pair, Pair], slant: Pair | None, probes: tuple[int, int]) -> Vec3:
        """The mean over the pixel in which uv is (steps_u s + steps_v t) / (1 + slant_u s + slant_v t) away from its
        middle, s and t from -1/2 to 1/2, by so many probes along the shorter and the longer side.

        Which level a probe reads has no derivative.
        """
        across, down = (_map_pair(lambda s: jnp.clip(s, -LARGEST_STEP, LARGEST_STEP), step) for step in steps)
        none = jnp.zeros_like(uv[0])
        slant = (none, none) if slant is None else slant
        # Let the second side be the longer one.
        turn = jnp.greater(*self.spread((across, down)))
        short, long = _exchanged(turn, across, down)
        slant_short, slant_long = (jnp.where(turn, *pair) for pair in (slant[::-1], slant))
        along_short, along_long = (jnp.asarray(_middles(n), none.dtype) for n in probes)

        def strip(total, t):
            # Find the middle of the strip, its sides, and the level on which its probes are a texel apart.
            near = 1 / (1 + slant_long * t)
            moved = [side * (t * near) for side in long]
            width = [(side - by * slant_short) * near for side, by in zip(short, moved, strict=True)]
            height = [side * near * near for side in long]
            apart = jnp.maximum(
                *(a / n for a, n in zip(self.spread((tuple(width), tuple(height))), probes, strict=True))
            )
            level = self._level(apart)
            sizes = np.asarray(level_sizes(*self.size))
            rows, columns = (lookup(jnp.asarray(sizes[:, k], none.dtype), level) for k in (0, 1))
            first = lookup(jnp.asarray(_starts(sizes), jnp.int32), level) + self.which * self.texels.shape[1]
            # Add the probes across it.
            for s in along_short:
                u, v = (c + by + w * s for c, by, w in zip(uv, moved, width, strict=True))
                total = total + self._bilinear(u, v, rows, columns, first)
            return total, None

        total, _ = jax.lax.scan(strip, Vec3(none, none, none), along_long)
        return total * (1 / (probes[0] * probes[1]))

    def softened(self, u: Float[Array, "*n"], v: Float[Array, "*n"], spread: Float[Array, "*n"]) -> Vec3:
        """About the mean over a square of so many texels: between the two levels whose texels are as large; continuous
        in `spread`.
        """
        return self._between(spread, lambda *level: self._bilinear(u, v, *level))

    def slopes(
        self, u: Float[Array, "*n"], v: Float[Array, "*n"], spread: Float[Array, "*n"]
    ) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """How the mean of the channels of `softened` rises in u and in v: differences over a texel of each level, so
        that they are continuous where bilinear interpolation bends.
        """

        def height(u, v, *level):
            colour = self._bilinear(u, v, *level)
            return (colour.x + colour.y + colour.z) / 3

        def rise(rows, columns, first):
            across, up, level = 0.5 / columns, 0.5 / rows, (rows, columns, first)
            return (
                (height(u + across, v, *level) - height(u - across, v, *level)) * columns,
                (height(u, v + up, *level) - height(u, v - up, *level)) * rows,
            )

        return self._between(spread, rise)

    def _between(self, spread: Float[Array, "*n"], look: Callable):
        """What `look(rows, columns, first texel)` gives, between the two levels whose texels are `spread` wide."""
        last = len(level_sizes(*self.size)) - 1
        # What is not alive may hold anything.
        spread = jnp.where(jnp.isfinite(spread), spread, 1)
        place = jnp.log2(jnp.clip(spread, 1.0, 2.0**last))
        lower = jnp.clip(jnp.floor(jax.lax.stop_gradient(place)).astype(jnp.int32), 0, max(last - 1, 0))
        part = place - lower
        sizes = np.asarray(level_sizes(*self.size))

        def level(number):
            rows, columns = (lookup(jnp.asarray(sizes[:, k], spread.dtype), number) for k in (0, 1))
            first = lookup(jnp.asarray(_starts(sizes), jnp.int32), number) + self.which * self.texels.shape[1]
            return look(rows, columns, first)

        fine, coarse = level(lower), level(jnp.minimum(lower + 1, last))
        return jax.tree.map(lambda a, b: a * (1 - part) + b * part, fine, coarse)

    def _level(self, apart: Float[Array, "*n"]) -> Int[Array, "*n"]:
        """The level whose texels are `apart`, to the nearest power of two."""
        last = len(level_sizes(*self.size)) - 1
        apart = jnp.clip(jnp.nan_to_num(jax.lax.stop_gradient(apart), nan=1.0), 1.0, 2.0 ** (last + 1))
        return jnp.clip(jnp.round(jnp.log2(apart)).astype(jnp.int32), 0, last)

    def _bilinear(self, u, v, rows, columns, first) -> Vec3:
        """On a level of so many rows and columns whose texels begin at `first`."""
        (left, right, part), (low, high, rise) = (self._two(u, columns), self._two(v, rows))
        lower, upper = first + low * _whole(columns), first + high * _whole(columns)
        a, b, c, d = (self._texel(line + column) for line in (lower, upper) for column in (left, right))
        bottom = a * (1 - part) + b * part
        return bottom * (1 - rise) + (c * (1 - part) + d * part) * rise

    def _two(self, coordinate, count):
        """The texels before and after a coordinate along one axis, and the part of the way between them."""
        # What is not alive may hold anything.
        coordinate = jnp.where(jnp.isfinite(coordinate), coordinate, 0)
        # Bring it into the picture, where its digits are.
        if self.wrap == "repeat":
            inside = coordinate - jnp.floor(coordinate)
        elif self.wrap == "clamp":
            inside = jnp.clip(coordinate, 0, 1)
        else:
            twice = coordinate - 2 * jnp.floor(0.5 * coordinate)
            inside = jnp.where(twice > 1, 2 - twice, twice)
        place = inside * count - 0.5
        before = jnp.floor(place)
        part = place - before
        first, last = before.astype(jnp.int32), _whole(count) - 1
        second = first + 1
        if self.wrap == "repeat":
            return jnp.where(first < 0, last, first), jnp.where(second > last, 0, second), part
        return jnp.clip(first, 0, last), jnp.clip(second, 0, last), part

    def _texel(self, number) -> Vec3:
        columns = self.texels.reshape(-1, 3)
        return Vec3(*(jnp.take(columns[:, k], number, mode="clip") for k in range(3)))


def _exchanged(turn, across: Pair, down: Pair) -> tuple[Pair, Pair]:
    """The two sides, exchanged where it is their turn."""
    short, long = zip(
        *((jnp.where(turn, d, a), jnp.where(turn, a, d)) for a, d in zip(across, down, strict=True)), strict=True
    )
    return (short[0], short[1]), (long[0], long[1])


def _map_pair(change: Callable, pair: Pair) -> Pair:
    return change(pair[0]), change(pair[1])


def _whole(count):
    return count.astype(jnp.int32)


def _middles(count: int) -> np.ndarray:
    """The middles of equal parts of -1/2 .. 1/2."""
    return (np.arange(count) + 0.5) / count - 0.5


def _starts(sizes: np.ndarray) -> np.ndarray:
    """Where each level begins."""
    return np.cumsum([0, *sizes.prod(axis=1)[:-1]])
