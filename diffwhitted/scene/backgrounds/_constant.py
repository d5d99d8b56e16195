"""One colour all around."""

from typing import ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...numerics._vector import Vec3, vec3
from ...records import Row, number_array, require
from ._background import AbstractBackground


class ConstantBackground(AbstractBackground):
    """One linear RGB colour in every direction."""

    TYPE: ClassVar[str] = "constant"
    SHORT: ClassVar[bool] = True
    ROWS: ClassVar[tuple[Row, ...]] = (Row("colour", "colour", "Linear RGB.", lowest=0),)

    colour: Float[Array, "3"]

    def __init__(self, colour, place: str = "scene"):
        self.colour = number_array(colour, place, "background", ((3,),))
        require(lambda c: (c >= 0).all(), place, "background", self.colour, ">= 0")

    def seen(self, direction: Vec3) -> Vec3:
        return vec3(self.colour) * jnp.ones_like(direction.x)

    def brightest(self) -> np.ndarray:
        return np.asarray(self.colour, np.float64)
