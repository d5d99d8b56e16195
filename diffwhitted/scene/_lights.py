"""Light sources: where their light comes from and how much of it arrives."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics._safe import length, normalise, rescaled, safe_divide
from ..numerics._vector import Vec3, vec3
from ._checks import number_array, require


class PointLight(eqx.Module):
    """A point that shines alike in all directions.

    Its colour arrives unchanged at any distance unless `attenuation` = (a0, a1, a2) is given: then it is
    multiplied by min(1, 1 / (a0 + a1 d + a2 d**2)) (Hearn and Baker, intensity attenuation).
    """

    position: Float[Array, "3"]
    colour: Float[Array, "3"]
    attenuation: Float[Array, "3"] | None = None

    def __init__(self, position, colour, attenuation=None, place: str = "point light"):
        self.position = number_array(position, place, "position", ((3,),))
        self.colour = _colour(colour, place)
        self.attenuation = None
        if attenuation is not None:
            self.attenuation = number_array(attenuation, place, "attenuation", ((3,),))
            require(
                lambda a: (a >= 0).all() and a.any(),
                place,
                "attenuation",
                self.attenuation,
                "three numbers >= 0, not all zero",
            )

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """Unit direction to the light, its distance, and the colour that arrives unless blocked.

        Edge: a point at the light's own position gets a zero direction, hence no light.
        """
        to_light = vec3(self.position) - point
        distance = length(to_light)
        colour = vec3(self.colour)
        if self.attenuation is None:
            return normalise(to_light), distance, colour
        a0, a1, a2 = self.attenuation
        fade = jnp.minimum(1, safe_divide(1, a0 + a1 * distance + a2 * distance * distance, otherwise=1))
        return normalise(to_light), distance, colour * fade


class DirectionalLight(eqx.Module):
    """A light at infinity; `direction` points towards it and need not have unit length."""

    direction: Float[Array, "3"]
    colour: Float[Array, "3"]

    def __init__(self, direction, colour, place: str = "directional light"):
        self.direction = number_array(direction, place, "direction", ((3,),))
        require(lambda d: (d != 0).any(), place, "direction", self.direction, "any vector but zero")
        self.colour = _colour(colour, place)

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """Unit direction to the light, its distance (infinite), and the colour that arrives."""
        direction = normalise(rescaled(vec3(self.direction))[0])
        ones = jnp.ones_like(point.x)
        return direction * ones, ones * jnp.inf, vec3(self.colour)


def _colour(colour, place: str):
    array = number_array(colour, place, "colour", ((), (3,)))
    require(lambda c: (c >= 0).all(), place, "colour", array, ">= 0")
    return jnp.broadcast_to(array, (3,))


Light = PointLight | DirectionalLight
