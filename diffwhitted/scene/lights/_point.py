"""Point lights."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._safe import length, normalise, rescaled
from ...numerics._vector import Vec3, vec3
from ...records import Row, read_rows
from ._light import COLOUR, AbstractLight


class PointLight(AbstractLight):
    """A point that shines alike in all directions.

    Its colour arrives unchanged at any distance unless `attenuation` = (a0, a1, a2) is given: then it is
    multiplied by min(1, 1 / (a0 + a1 d + a2 d**2)) (Hearn and Baker, intensity attenuation). With
    `attenuation_limit` = "none" it is not held at 1 near the light: (0, 0, 1) is then the inverse square everywhere.
    """

    TYPE: ClassVar[str] = "point"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("position", "vector", "Where the light is, metres.", unit="m", scale="unbounded", moves="shadows"),
        COLOUR,
        Row("attenuation", "vector", "a0, a1 (1/m), a2 (1/m^2): the colour is multiplied by "
            "min(1, 1 / (a0 + a1 d + a2 d^2)); no fade without it.", default=None, lowest=0, nonzero=True,
            parts=("a0", "a1", "a2")),
        Row("attenuation_limit", "choice", "one (the default): near the light, where the attenuation would make more "
            "of the colour, it is held at 1; none: it is not.", default=None, choices=("one", "none")),
    )  # fmt: skip

    position: Float[Array, "3"]
    colour: Float[Array, "3"]
    attenuation: Float[Array, "3"] | None
    attenuation_limit: str | None = eqx.field(static=True)
    name: str | None = eqx.field(static=True)

    def __init__(
        self,
        position,
        colour,
        attenuation=None,
        name: str | None = None,
        place: str = "point light",
        attenuation_limit: str | None = None,
    ):
        self.name, self.attenuation_limit = name, attenuation_limit
        if attenuation_limit not in (None, "one", "none"):
            raise SceneError(f'{place}: attenuation_limit = {attenuation_limit!r}; allowed is "one" or "none"')
        if attenuation_limit is not None and attenuation is None:
            raise SceneError(f"{place}: attenuation_limit without an attenuation, which it is about; give one")
        read_rows(self, place, position=position, colour=colour, attenuation=attenuation)

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """Unit direction to the light, its distance, and the colour that arrives unless occluded.

        Edge: a point at the light's own position gets a zero direction, hence no light.
        """
        to_light, power = rescaled(vec3(self.position) - point)
        distance, direction, colour = length(to_light) / power, normalise(to_light), vec3(self.colour)
        if self.attenuation is None:
            return direction, distance, colour
        return direction, distance, colour * _fade(self.attenuation, distance, self.attenuation_limit != "none")

    def brightest(self) -> np.ndarray:
        """Where the fade is not held at 1 it is 1 / a0 at the light itself."""
        colour = np.asarray(self.colour, np.float64)
        if self.attenuation is None or self.attenuation_limit != "none":
            return colour
        nearest = float(np.asarray(self.attenuation)[0])
        return np.where(colour > 0, colour / nearest if nearest > 0 else np.inf, 0.0)

    def held_within(self) -> float:
        """The distance at which a0 + a1 d + a2 d**2 = 1."""
        if self.attenuation is None or self.attenuation_limit == "none":
            return 0.0
        a0, a1, a2 = np.asarray(self.attenuation, np.float64)
        if a0 >= 1:
            return 0.0
        if a2 > 0:
            return float((np.sqrt(a1 * a1 + 4 * a2 * (1 - a0)) - a1) / (2 * a2))
        return float((1 - a0) / a1) if a1 > 0 else 0.0

    def place(self) -> np.ndarray:
        return np.asarray(self.position, np.float64)

    @property
    def fades(self) -> bool:
        return self.attenuation is not None

    def without_fading(self) -> "PointLight":
        return PointLight(self.position, self.colour, name=self.name)


def _fade(attenuation: Float[Array, "... 3"], distance: Float[Array, "*n"], held: bool) -> Float[Array, "*n"]:
    """The attenuation, numerator and denominator divided by a far distance, so that no square of it is formed.

    Edge: where it is not `held` at 1 and grows without end, at the light itself, it is 1 with derivative 0.
    """
    a0, a1, a2 = (attenuation[..., k] for k in range(3))
    part = 1 / jnp.maximum(jax.lax.stop_gradient(distance), 1)
    total = a0 * part + (a1 + a2 * distance) * (distance * part)
    fades = total >= part if held else total > 0
    return jnp.where(fades, part / jnp.where(fades, total, 1), 1)
