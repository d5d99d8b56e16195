"""What a ray sees that meets nothing. A new background is a record here."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..numerics._vector import Vec3, vec3
from ._checks import number_array, require


class ConstantBackground(eqx.Module):
    """One linear RGB colour in every direction."""

    colour: Float[Array, "3"]

    def __init__(self, colour, place: str = "scene"):
        self.colour = number_array(colour, place, "background", ((3,),))
        require(lambda c: (c >= 0).all(), place, "background", self.colour, ">= 0")

    def seen(self, direction: Vec3) -> Vec3:
        return vec3(self.colour) * jnp.ones_like(direction.x)

    def brightest(self) -> np.ndarray:
        return np.asarray(self.colour, np.float64)


class GradientBackground(eqx.Module):
    """From `bottom` straight down to `top` straight up, linear in the height (1 + u_y) / 2 of the direction."""

    bottom: Float[Array, "3"]
    top: Float[Array, "3"]

    def __init__(self, bottom, top, place: str = "scene"):
        self.bottom = number_array(bottom, place, "background.gradient[0]", ((3,),))
        self.top = number_array(top, place, "background.gradient[1]", ((3,),))
        for colour in (self.bottom, self.top):
            require(lambda c: (c >= 0).all(), place, "background.gradient", colour, ">= 0")

    def seen(self, direction: Vec3) -> Vec3:
        height = 0.5 * (1 + direction.y)
        return vec3(self.bottom) * (1 - height) + vec3(self.top) * height

    def brightest(self) -> np.ndarray:
        return np.maximum(np.asarray(self.bottom, np.float64), np.asarray(self.top, np.float64))


Background = ConstantBackground | GradientBackground
