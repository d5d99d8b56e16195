"""Point lights."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...numerics._safe import length, normalise, rescaled
from ...numerics._vector import Vec3, vec3
from ...records import Row, read_rows
from ._light import COLOUR, AbstractLight


class PointLight(AbstractLight):
    """A point that shines alike in all directions.

    Its colour arrives unchanged at any distance unless `attenuation` = (a0, a1, a2) is given: then it is
    multiplied by min(1, 1 / (a0 + a1 d + a2 d**2)) (Hearn and Baker, intensity attenuation).
    """

    TYPE: ClassVar[str] = "point"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("position", "vector", "Where the light is, metres.", unit="m", scale="unbounded", moves="shadows"),
        COLOUR,
        Row("attenuation", "vector", "a0, a1 (1/m), a2 (1/m^2): the colour is multiplied by "
            "min(1, 1 / (a0 + a1 d + a2 d^2)); no fade without it.", default=None, lowest=0, nonzero=True,
            parts=("a0", "a1", "a2")),
    )  # fmt: skip

    position: Float[Array, "3"]
    colour: Float[Array, "3"]
    attenuation: Float[Array, "3"] | None
    name: str | None = eqx.field(static=True)

    def __init__(self, position, colour, attenuation=None, name: str | None = None, place: str = "point light"):
        self.name = name
        read_rows(self, place, position=position, colour=colour, attenuation=attenuation)

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """Unit direction to the light, its distance, and the colour that arrives unless occluded.

        Edge: a point at the light's own position gets a zero direction, hence no light.
        """
        to_light, power = rescaled(vec3(self.position) - point)
        distance, direction, colour = length(to_light) / power, normalise(to_light), vec3(self.colour)
        if self.attenuation is None:
            return direction, distance, colour
        return direction, distance, colour * _fade(self.attenuation, distance)

    def brightest(self) -> np.ndarray:
        return np.asarray(self.colour, np.float64)

    def place(self) -> np.ndarray:
        return np.asarray(self.position, np.float64)

    @property
    def fades(self) -> bool:
        return self.attenuation is not None

    def without_fading(self) -> "PointLight":
        return PointLight(self.position, self.colour, name=self.name)


def _fade(attenuation: Float[Array, "... 3"], distance: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """The attenuation, numerator and denominator divided by a far distance, so that no square of it is formed."""
    a0, a1, a2 = (attenuation[..., k] for k in range(3))
    part = 1 / jnp.maximum(jax.lax.stop_gradient(distance), 1)
    total = a0 * part + (a1 + a2 * distance) * (distance * part)
    fades = total >= part
    return jnp.where(fades, part / jnp.where(fades, total, 1), 1)
