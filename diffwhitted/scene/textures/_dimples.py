"""Dimples: a round dent in each cell."""

from math import pi
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...numerics._vector import Vec3, vec3
from ...records import Row, changed, is_traced, number_array, read_rows
from ._pattern import AXES, COLOURS, AbstractPattern, left_of_wave, read_axes, read_colours

MEAN = {1: 16 / 35, 2: pi / 16, 3: 4 * pi * 16 / 315 / 8}
"""Of a dent as wide as its cell, by the number of axes: of (1 - r**2)**3 over a ball of radius 1/2."""


class Dimples(AbstractPattern):
    """v = 1 - (1 - r**2)**3 within r < 1, else 1, with r the distance from the middle of the cell, over the listed
    axes, divided by the radius of a dent, `share` / 2 of the cell. In the origin there is the middle of a cell.
    """

    TYPE: ClassVar[str] = "dimples"
    ROWS: ClassVar[tuple[Row, ...]] = (
        COLOURS,
        Row("size", "number", "Edge of a cell, metres.", unit="m", default=1.0, lowest=0, excluded=True, scale="log",
            moves="patterns"),
        Row("share", "number", "Diameter of a dent as a share of its cell.", default=0.8, lowest=0.01, highest=1,
            moves="patterns"),
        AXES,
    )  # fmt: skip

    colours: Float[Array, "2 3"]
    size: Float[Array, ""]
    share: Float[Array, ""]
    corner: Float[Array, "3"]
    """The middle of a cell: the origin, unless the pattern was moved (less than a cell)."""
    axes: str = eqx.field(static=True)

    def __init__(self, colours=COLOURS.default, size=1.0, share=0.8, axes: str = "xyz", place: str = "texture"):
        self.colours, self.axes = read_colours(colours, place), read_axes(axes, place)
        read_rows(self, place, size=size, share=share)
        self.corner = number_array((0.0, 0.0, 0.0), place, "corner", ((3,),))

    def moved(self, by: np.ndarray) -> "Dimples":
        period = self.size if is_traced(self.size) else np.asarray(self.size, np.float64)
        return changed(self, corner=(self.corner + by) % period)

    def finest(self):
        return self.size * self.share

    def number(self, position: Vec3, width):
        away = position - vec3(self.corner)
        square = jnp.zeros_like(away.x)
        for axis in self.axes:
            along = getattr(away, axis) / self.size
            part = (along - jnp.floor(along + 0.5)) / (0.5 * self.share)
            square = square + part * part
        inside = jnp.maximum(1 - square, 0)
        dent = inside * inside * inside
        if width is None:
            return 1 - dent
        mean = MEAN[len(self.axes)] * self.share ** len(self.axes)
        return 1 - mean - (dent - mean) * left_of_wave(self.size * self.share, width)
