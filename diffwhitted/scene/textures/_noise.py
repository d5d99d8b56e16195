"""Noise: a smooth random number at each point of space."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ...numerics._vector import Vec3, vec3
from ...records import Row, changed, is_traced, number_array, read_rows
from ._pattern import AXES, COLOURS, AbstractPattern, left_of_wave, read_axes, read_colours

PERIOD = 256
"""Cells after which the noise repeats, along each axis."""
LARGEST = 3**0.5 / 2
"""Of noise with unit gradients: in the middle of a cell all of whose corners lean towards it."""
GRADIENTS = np.array(
    [
        (0, 1, 1), (0, 1, -1), (0, -1, 1), (0, -1, -1), (1, 0, 1), (1, 0, -1), (-1, 0, 1), (-1, 0, -1), (1, 1, 0),
        (1, -1, 0), (-1, 1, 0), (-1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, -1, 1), (0, -1, -1),
    ],
    np.float64,
)  # fmt: skip
"""Times the root of 1/2, for four bits."""


class Noise(AbstractPattern):
    """Gradient noise (Perlin 1985, 2002) in octaves, each of half the size and half the height of the one before.

    v = 1/2 + sum_k 2**-k n(2**k P / size) / (2 (2 - 2**(1 - octaves)) max |n|). It repeats after 256 cells.
    """

    TYPE: ClassVar[str] = "noise"
    ROWS: ClassVar[tuple[Row, ...]] = (
        COLOURS,
        Row("size", "number", "Edge of a cell of the coarsest octave, metres: about the size of its bumps.", unit="m",
            default=1.0, lowest=0, excluded=True, scale="log", moves="patterns"),
        Row("octaves", "count", "How many, each of half the size and half the height of the one before.", default=3,
            lowest=1, highest=8),
        AXES,
    )  # fmt: skip

    colours: Float[Array, "2 3"]
    size: Float[Array, ""]
    corner: Float[Array, "3"]
    """Of its cells: the origin, unless the pattern was moved (less than a period, after which it repeats)."""
    octaves: int = eqx.field(static=True)
    axes: str = eqx.field(static=True)

    def __init__(self, colours=COLOURS.default, size=1.0, octaves: int = 3, axes: str = "xyz", place: str = "texture"):
        self.colours, self.axes = read_colours(colours, place), read_axes(axes, place)
        read_rows(self, place, size=size, octaves=octaves)
        self.corner = number_array((0.0, 0.0, 0.0), place, "corner", ((3,),))

    def moved(self, by: np.ndarray) -> "Noise":
        period = PERIOD * (self.size if is_traced(self.size) else np.asarray(self.size, np.float64))
        return changed(self, corner=(self.corner + by) % period)

    def finest(self):
        return self.size * 2.0 ** (1 - self.octaves)

    def number(self, position: Vec3, width):
        away = position - vec3(self.corner)
        along = {axis: getattr(away, axis) if axis in self.axes else jnp.zeros_like(away.x) for axis in "xyz"}
        shares = 0.5 ** np.arange(self.octaves)

        def add(total, octave):
            salt, share = octave
            cell = self.size * share
            noise = gradient_noise(Vec3(*(a / cell for a in along.values())), self.axes, salt)
            return total + noise * (share * left_of_wave(cell, width)), None

        octaves = jnp.arange(self.octaves, dtype=jnp.uint32), jnp.asarray(shares, away.x.dtype)
        total, _ = jax.lax.scan(add, jnp.zeros_like(away.x), octaves)
        return 0.5 + total / (2 * LARGEST * shares.sum())


def gradient_noise(place: Vec3, axes: str, salt: Int[Array, ""]) -> Float[Array, "*n"]:
    """Noise of unit gradients at the corners of unit cells, from -`LARGEST` to `LARGEST`; 0 at the corners. Its first
    and second derivatives are continuous (Perlin 2002). Along axes that are not listed it is asked at 0.
    """
    cells = [jnp.floor(getattr(place, axis)) for axis in "xyz"]
    parts = [getattr(place, axis) - cell for axis, cell in zip("xyz", cells, strict=True)]
    whole = [(cell - PERIOD * jnp.floor(cell / PERIOD)).astype(jnp.uint32) for cell in cells]
    fades = [t * t * t * (t * (6 * t - 15) + 10) for t in parts]
    table = [jnp.asarray(column, place.x.dtype) for column in (GRADIENTS * 0.5**0.5).T]

    def add(total, corner):
        sides = [side.astype(place.x.dtype) for side in corner]
        number = _mixed([(w + side) % jnp.uint32(PERIOD) for w, side in zip(whole, corner, strict=True)], salt)
        weight, height = jnp.ones_like(total), jnp.zeros_like(total)
        for lean, part, fade, side in zip(table, parts, fades, sides, strict=True):
            weight = weight * (side * fade + (1 - side) * (1 - fade))
            height = height + jnp.take(lean, number) * (part - side)
        return total + weight * height, None

    corners = np.asarray(list(np.ndindex(*(1 + (axis in axes) for axis in "xyz"))), np.uint32)
    return jax.lax.scan(add, jnp.zeros_like(place.x), tuple(jnp.asarray(corners.T)))[0]


def _mixed(cell: list[Int[Array, "*n"]], salt: Int[Array, ""]) -> Int[Array, "*n"]:
    """Four bits that hang on a cell (the finaliser of MurmurHash3)."""
    total = jnp.uint32(0x9E3779B9) + jnp.uint32(0x632BE5AB) * salt
    for number in cell:
        total = (total ^ number) * jnp.uint32(0x85EBCA6B)
        total = (total ^ (total >> 13)) * jnp.uint32(0xC2B2AE35)
        total = total ^ (total >> 16)
    return (total >> 8).astype(jnp.int32) & 15
