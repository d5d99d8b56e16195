"""A sky that changes with the height."""

from typing import ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...numerics._vector import Vec3, vec3
from ...records import Row, number_array, require
from ._background import AbstractBackground
from ._constant import ConstantBackground


class GradientBackground(AbstractBackground):
    """From `bottom` straight down to `top` straight up, linear in the height (1 + u_y) / 2 of the direction."""

    TYPE: ClassVar[str] = "gradient"
    SHORT: ClassVar[bool] = True
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("bottom", "colour", "Linear RGB straight down.", lowest=0),
        Row("top", "colour", "Linear RGB straight up.", lowest=0),
    )

    bottom: Float[Array, "3"]
    top: Float[Array, "3"]

    def __init__(self, bottom, top, place: str = "scene"):
        self.bottom = number_array(bottom, place, "background.gradient[0]", ((3,),))
        self.top = number_array(top, place, "background.gradient[1]", ((3,),))
        for colour in (self.bottom, self.top):
            require(lambda c: (c >= 0).all(), place, "background.gradient", colour, ">= 0")

    def seen(self, direction: Vec3) -> Vec3:
        height = jnp.clip(0.5 * (1 + direction.y), 0, 1)
        return vec3(self.bottom) * (1 - height) + vec3(self.top) * height

    def brightest(self) -> np.ndarray:
        return np.maximum(np.asarray(self.bottom, np.float64), np.asarray(self.top, np.float64))

    def plain(self) -> ConstantBackground:
        return ConstantBackground(self.top)
