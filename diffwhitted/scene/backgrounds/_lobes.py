"""A map averaged with the weight (n + 1) / (2 pi) max(cos, 0)^n about every direction, for a ladder of exponents n.

Rung k has n + 1 = 2^k, on a grid whose texels are at most `FINEST` of the width 1 / sqrt(n + 1) of the lobe; above the
last rung is the map itself. Between rungs a cubic of Catmull and Rom in log2(n + 1) is taken, beyond the last one the
place on the way to the map goes with 1 / (n + 1). Where a lobe is wider than 2.5 texels all this is within 4 % of the
largest that a lamp of one texel gives, and of a smooth map within 0.2 %.
"""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...numerics._vector import Vec3
from ...records import is_traced
from ._map_levels import MapLevels, halved, joined, place_on_map, refined, solid_angles

FINEST = 0.25
LAST_RUNG = 12
"""n = 4095, a lobe less than a degree wide."""
NARROWEST = 1.25
"""Texels of the map: a lobe that is not as wide sees the map itself."""
OVERSHOOT = 1.125
"""The weights above 0 of a cubic of Catmull and Rom are at most so much in all; those below 0 are -1/8."""
LEAST_ROWS, MOST_ROWS = 64, 256
"""Of a rung, where the map has as many."""
ROWS_AT_ONCE = 64
NOTHING = 1e-5
"""Below this share of its peak a lobe is left out."""


class Lobes(eqx.Module):
    """The rungs, and the map itself as the last of them."""

    rungs: MapLevels
    scale: Float[Array, ""]
    rotation_deg: Float[Array, ""]

    def at(self, direction: Vec3, exponent: Float[Array, "*n"]) -> Vec3:
        """The mean about each direction, weighted by its exponent n >= 0; differentiable in all of them."""
        last = len(self.rungs.sizes) - 1
        # Find the place on the ladder.
        top = 2.0 ** (last - 1)
        within = exponent + 1 < top
        place = jnp.where(
            within, jnp.log2(1 + jnp.where(within, exponent, 0)), last - top / jnp.where(within, top, exponent + 1)
        )
        below = jnp.clip(jnp.floor(place), 0, last - 1)
        weights, rung = _cubic(place - below, below == 0), below.astype(jnp.int32)
        # Mix the rungs around it.
        across, down = place_on_map(direction, self.rotation_deg)
        total = Vec3(*(jnp.zeros_like(across) for _ in range(3)))
        for step, weight in zip((-1, 0, 1, 2), weights, strict=True):
            total = total + self.rungs.at(across, down, jnp.clip(rung + step, 0, last)) * weight
        return total * self.scale


def _cubic(part, lowest) -> list:
    """The weights of four rungs for a place between the middle two; where there is none below, a straight line goes on
    there.
    """
    one = 0.5 * part * (-1 + part * (2 - part))
    two = 1 + 0.5 * part * part * (3 * part - 5)
    three = 0.5 * part * (1 + part * (4 - 3 * part))
    four = 0.5 * part * part * (part - 1)
    none = jnp.zeros_like(one)
    beyond = jnp.where(lowest, one, none)
    return [one - beyond, two + 2 * beyond, three - beyond, four]


def rungs_of(texels):
    """All rungs of a map and the map itself, (all, 3), and their sizes; linear in the texels."""
    levels = [level for level in halved(refined(texels)) if level.shape[0] <= MOST_ROWS]
    last = int(np.clip(np.floor(-2 * np.log2(NARROWEST * _texel(levels[0].shape))), 1, LAST_RUNG))
    rungs = []
    for rung in range(last + 1):
        fine = [level for level in levels if _is_fine(level.shape, 2.0 ** (-rung / 2))]
        rungs.append(_averaged(fine[-1] if fine else levels[0], rung))
    return joined([*rungs, texels])


def _is_fine(shape: tuple[int, ...], width: float) -> bool:
    return _texel(shape) <= FINEST * width and shape[0] >= LEAST_ROWS


def _texel(shape: tuple[int, ...]) -> float:
    """The angle between texels, where it is largest."""
    return max(np.pi / shape[0], 2 * np.pi / shape[1])


def _averaged(level, rung: int):
    """A map averaged with the lobe of a rung, by a circular convolution along its rows."""
    xp: Any = jnp if is_traced(level) else np
    rows, columns = level.shape[:2]
    waves, parts = xp.fft.rfft(level, axis=1), []
    for start in range(0, rows, ROWS_AT_ONCE):
        here = np.arange(start, min(start + ROWS_AT_ONCE, rows))
        near, kernel = _kernel(here, rows, columns, 2.0**rung - 1)
        kernel = kernel.astype(np.complex64 if level.dtype == np.float32 else np.complex128)
        parts.append(xp.einsum("rbw,rbwk->rwk", kernel, waves[near]))
    return xp.fft.irfft(xp.concatenate(parts), columns, axis=1).astype(level.dtype)


def _kernel(here: np.ndarray, rows: int, columns: int, exponent: float) -> tuple[np.ndarray, np.ndarray]:
    """The rows that each row of `here` is averaged over, and the Fourier transforms of the weights of their texels,
    which are 1 in all.
    """
    reach = np.pi / 2 if exponent < 2 else np.arccos(NOTHING ** (1 / exponent))
    band = min(rows, 2 * int(np.ceil(reach / np.pi * rows) + 1) + 1)
    near = np.clip(here - band // 2, 0, rows - band)[:, None] + np.arange(band)
    polar, turn = (np.arange(rows) + 0.5) * np.pi / rows, 2 * np.pi * np.arange(columns) / columns
    upright, flat = (f(polar[here])[:, None] * f(polar[near]) for f in (np.cos, np.sin))
    # The weights are the same to the left and to the right.
    half = columns // 2 + 1
    cosine = upright[..., None] + flat[..., None] * np.cos(turn[:half])
    weight = np.where(cosine > 0, np.maximum(cosine, 0) ** exponent, 0.0) * solid_angles(rows)[near][..., None]
    weight = np.concatenate([weight, weight[..., columns - half : 0 : -1]], axis=2)
    return near, np.fft.rfft(weight / weight.sum(axis=(1, 2), keepdims=True), axis=2)
