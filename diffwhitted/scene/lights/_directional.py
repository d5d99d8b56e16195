"""Directional lights."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...numerics._safe import normalise, rescaled
from ...numerics._vector import Vec3, vec3
from ...records import Row, read_rows
from ._light import COLOUR, AbstractLight


class DirectionalLight(AbstractLight):
    """A light at infinity; `direction` points towards it and need not have unit length."""

    TYPE: ClassVar[str] = "directional"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("direction", "direction", "Towards the light; any length but zero.", nonzero=True, scale="unbounded",
            moves="shadows"),
        COLOUR,
    )  # fmt: skip

    direction: Float[Array, "3"]
    colour: Float[Array, "3"]
    name: str | None = eqx.field(static=True)

    def __init__(self, direction, colour, name: str | None = None, place: str = "directional light"):
        self.name = name
        read_rows(self, place, direction=direction, colour=colour)

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """Unit direction to the light, its distance (infinite), and the colour that arrives."""
        direction = normalise(rescaled(vec3(self.direction))[0])
        ones = jnp.ones_like(point.x)
        return direction * ones, ones * jnp.inf, vec3(self.colour)

    def brightest(self) -> np.ndarray:
        return np.asarray(self.colour, np.float64)

    @property
    def outside(self) -> bool:
        return True
