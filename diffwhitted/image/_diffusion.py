"""Error diffusion and dot diffusion: a picture on few levels, whose errors neighbours make good.

Hearn and Baker, Computer Graphics, C version, 2nd edition (1997), section 14-4, (14-36) and figure 14-43; Floyd and
Steinberg (1976); Knuth, Digital halftones by dot diffusion (1987).
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .._errors import InputError
from ._levels import checked, nearest

FLOYD_STEINBERG = (7 / 16, 3 / 16, 5 / 16, 1 / 16)
RESCALED = 0.8, 0.1
"""What a value is multiplied by and what is added, against ghosts."""
CLASSES = np.asarray([
    [34, 48, 40, 32, 29, 15, 23, 31],
    [42, 58, 56, 53, 21, 5, 7, 10],
    [50, 62, 61, 45, 13, 1, 2, 18],
    [38, 46, 54, 37, 25, 17, 9, 26],
    [28, 14, 22, 30, 35, 49, 41, 33],
    [20, 4, 6, 11, 43, 59, 57, 52],
    [12, 0, 3, 19, 51, 63, 60, 44],
    [24, 16, 8, 27, 39, 47, 55, 36],
])  # fmt: skip
"""Of a pixel by its row and column modulo 8."""
AROUND = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1) if down or right]
UNROLLED = 8
"""Pixels that one turn of the loop of a row takes."""


def error_diffusion(
    image: Any,
    levels: int = 2,
    weights: Sequence[float] = FLOYD_STEINBERG,
    serpentine: bool = False,
    rescaled: bool = False,
) -> Any:
    """Each pixel on the level nearest to its value, the error going to its neighbours (Hearn and Baker, after (14-35)).

    image: (height, width) or (height, width, 3) of linear light in [0, 1]. weights: the parts of the error that go to
    the right, below to the left, below, and below to the right; >= 0, with a sum of at most 1 (14-36). With a smaller
    sum ghosts fade. rescaled: 0.8 times the value of a pixel and the errors that it was given, plus 0.1, is taken
    instead, so that an error fades by a fifth at each step and half the light stays half of it; the mean is not kept.
    serpentine: every other row runs from right to left, with its weights turned round.

    Errors do not go past the sides. Returns what is shown, of the same shape, in [0, 1]. May be compiled by `jax.jit`
    with all but the picture static. The derivative is 0. Raises `InputError`.
    """
    image = checked(image, levels, "error_diffusion")
    parts = tuple(float(weight) for weight in weights)
    if len(parts) != 4 or not all(0 <= part <= 1 for part in parts) or sum(parts) > 1 + 1e-12:
        raise InputError(
            f"error_diffusion: weights = {list(parts)}; allowed are four >= 0 with a sum of at most 1: to the right, "
            "below left, below, below right"
        )
    return (_by_rows if serpentine else _by_waves)(image, levels, parts, bool(rescaled))


def _shown(value: Any, levels: int, rescaled: bool) -> tuple[Any, Any]:
    """What is shown of a value with its errors, and the error that is left."""
    value = RESCALED[0] * value + RESCALED[1] if rescaled else value
    level = nearest(value, levels)
    return level, value - level


@partial(jax.jit, static_argnums=(1, 2, 3))
def _by_waves(image: Any, levels: int, parts: tuple[float, ...], rescaled: bool) -> Any:
    """All pixels with the same column + 2 row at once: none of them needs another of them."""
    height, width = image.shape[:2]
    right, below_left, below, below_right = parts
    rows = jnp.arange(height)
    columns = jnp.arange(width + 2 * (height - 1))[:, None] - 2 * rows
    there = (columns >= 0) & (columns < width)
    waves = image[rows, jnp.clip(columns, 0, width - 1)]
    there = there if image.ndim == 2 else there[..., None]

    def step(errors, wave):
        value, is_there = wave
        first, second, third = errors
        above = [jnp.concatenate([jnp.zeros_like(e[:1]), e[:-1]]) for e in errors]
        given = right * first + below_left * above[0] + below * above[1] + below_right * above[2]
        level, error = _shown(value + given, levels, rescaled)
        return (jnp.where(is_there, error, 0), first, second), level

    nothing = jnp.zeros_like(waves[0])
    _, shown = jax.lax.scan(step, (nothing,) * 3, (waves, there))
    return shown[jnp.arange(width) + 2 * rows[:, None], rows[:, None]]


@partial(jax.jit, static_argnums=(1, 2, 3))
def _by_rows(image: Any, levels: int, parts: tuple[float, ...], rescaled: bool) -> Any:
    """One pixel after the other, every other row turned round."""
    ahead, behind, below, further = parts
    odd = jnp.arange(len(image)) % 2 == 1

    def pixel(given, value):
        level, error = _shown(value + given, levels, rescaled)
        return ahead * error, (level, error)

    def row(given, values):
        pixels, turned = values
        pixels = jnp.where(turned, jnp.flip(pixels, 0), pixels)
        # Errors from above lie as the picture does.
        pixels = pixels + jnp.where(turned, jnp.flip(given, 0), given)
        _, (shown, errors) = jax.lax.scan(pixel, jnp.zeros_like(pixels[0]), pixels, unroll=UNROLLED)
        nothing = jnp.zeros_like(errors[:1])
        before, after = jnp.concatenate([errors[1:], nothing]), jnp.concatenate([nothing, errors[:-1]])
        following = behind * before + below * errors + further * after
        return jnp.where(turned, jnp.flip(following, 0), following), jnp.where(turned, jnp.flip(shown, 0), shown)

    _, shown = jax.lax.scan(row, jnp.zeros_like(image[0]), (image, odd))
    return shown


def dot_diffusion(image: Any, levels: int = 2) -> Any:
    """Each pixel on the level nearest to its value, in 64 turns by its class (`CLASSES`); the error goes to the
    neighbours of a larger class, diagonal ones with half the weight of the others (Knuth 1987).

    image: as in `error_diffusion`. What is in no class further on, at most a pixel or two of 64, keeps its error.
    Returns what is shown, of the same shape, in [0, 1]. May be compiled by `jax.jit` with `levels` static. The
    derivative is 0. Raises `InputError`.
    """
    return _by_classes(checked(image, levels, "dot_diffusion"), levels)


@partial(jax.jit, static_argnums=1)
def _by_classes(image: Any, levels: int) -> Any:
    height, width = image.shape[:2]
    tiles_down, tiles_across = -(-height // 8), -(-width // 8)
    padded = jnp.pad(image, [(0, 8 * tiles_down - height), (0, 8 * tiles_across - width), *[(0, 0)] * (image.ndim - 2)])
    first = jnp.asarray(np.stack(np.unravel_index(np.argsort(CLASSES, axis=None), (8, 8)), axis=1))
    classes = jnp.asarray(CLASSES)

    def turn(number, state):
        values, shown = state
        rows = first[number, 0] + 8 * jnp.arange(tiles_down)[:, None]
        columns = first[number, 1] + 8 * jnp.arange(tiles_across)
        level, error = _shown(values[rows, columns], levels, False)
        # Find the weights of the neighbours that are in the picture and come later.
        places, weights = [], []
        for down, right in AROUND:
            row, column = rows + down, columns + right
            inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
            later = classes[row % 8, column % 8] > number
            places.append((row, column))
            weights.append(jnp.where(inside & later, 1.0 if down and right else 2.0, 0.0).astype(values.dtype))
        total = sum(weights)
        for (row, column), weight in zip(places, weights, strict=True):
            share = jnp.where(total > 0, weight / jnp.where(total > 0, total, 1), 0)
            share = share if values.ndim == 2 else share[..., None]
            values = values.at[jnp.clip(row, 0), jnp.clip(column, 0)].add(error * share, mode="drop")
        return values, shown.at[rows, columns].set(level)

    _, shown = jax.lax.fori_loop(0, 64, turn, (padded, jnp.zeros_like(padded)))
    return shown[:height, :width]
