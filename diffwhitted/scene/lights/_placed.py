"""What lamps that stand somewhere have in common: the way to them, and how their light gets less with the distance."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._safe import length, normalise, rescaled
from ...numerics._vector import Vec3, vec3
from ...records import Row, changed, is_traced
from ._light import COLOUR, AbstractLight

POSITION = Row("position", "vector", "Where the light is, metres.", unit="m", scale="unbounded", moves="shadows")
FADE: tuple[Row, ...] = (
    Row("attenuation", "vector", "a0, a1 (1/m), a2 (1/m^2): the colour is multiplied by "
        "min(1, 1 / (a0 + a1 d + a2 d^2)); no fade without it.", default=None, lowest=0, nonzero=True,
        parts=("a0", "a1", "a2")),
    Row("clamped", "flag", "true (the default): near the light, where the attenuation would make more of the colour, "
        "it is held at 1; false: it is not.", default=None),
)  # fmt: skip


class AbstractFadingLight(AbstractLight):
    """A lamp whose light fades by `attenuation`.

    Its colour arrives unchanged at any distance unless `attenuation` = (a0, a1, a2) is given: then it is multiplied by
    min(1, 1 / (a0 + a1 d + a2 d**2)) (Hearn and Baker, intensity attenuation). With `clamped` = False it is not held
    at 1 near the light: (0, 0, 1) is then the inverse square everywhere.
    """

    colour: eqx.AbstractVar[Float[Array, "3"]]
    attenuation: eqx.AbstractVar[Float[Array, "3"] | None]
    clamped: eqx.AbstractVar[bool | None]

    @property
    def held(self) -> bool:
        """Is the fade held at 1 near the light?"""
        return self.clamped is not False

    def shone(self, to_light: Vec3) -> Vec3:
        """The colour that it sends against this unit direction, before any fade. By default its own."""
        del to_light
        return vec3(self.colour)

    def arriving_from(self, place: Float[Array, "3"], point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """What `arriving` is of a lamp at one place.

        Edge: a point at that very place gets a zero direction, hence no light.
        """
        there, power = rescaled(vec3(place) - point)
        direction, distance, colour = normalise(there), length(there) / power, self.shone(normalise(there))
        if self.attenuation is not None:
            colour = colour * _faded(self.attenuation, distance, self.held)
        return direction, distance, colour

    def brightest(self) -> np.ndarray:
        """Where the fade is not held at 1 it is 1 / a0 at the light itself."""
        colour = np.asarray(self.colour, np.float64)
        if self.attenuation is None or self.held:
            return colour
        nearest = float(np.asarray(self.attenuation)[0])
        return np.where(colour > 0, colour / nearest if nearest > 0 else np.inf, 0.0)

    def held_within(self) -> float:
        """The distance at which a0 + a1 d + a2 d**2 = 1; 0 where it is more at the light itself."""
        if self.attenuation is None or not self.held or is_traced(self.attenuation):
            return 0.0
        a0, a1, a2 = np.asarray(self.attenuation, np.float64)
        if a0 >= 1:
            return 0.0
        if a2 > 0:
            return float((np.sqrt(a1 * a1 + 4 * a2 * (1 - a0)) - a1) / (2 * a2))
        return float((1 - a0) / a1) if a1 > 0 else 0.0

    @property
    def fades(self) -> bool:
        return self.attenuation is not None

    def without_fading(self):
        return changed(self, attenuation=None, clamped=None)


class AbstractPlacedLight(AbstractFadingLight):
    """A lamp at a point; a kind says by `shone` how much it sends which way."""

    ROWS: ClassVar[tuple[Row, ...]] = (POSITION, COLOUR, *FADE)

    position: eqx.AbstractVar[Float[Array, "3"]]

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """Unit direction to the light, its distance, and the colour that arrives unless occluded.

        Edge: a point at the light's own position gets a zero direction, hence no light.
        """
        return self.arriving_from(self.position, point)

    def place(self) -> np.ndarray:
        return np.asarray(self.position, np.float64)


def checked_clamp(clamped, attenuation, place: str) -> bool | None:
    """The key `clamped`. Raises `SceneError` where it is no flag, and where there is no fade that it is about."""
    if clamped is None:
        return None
    if attenuation is None:
        raise SceneError(f"{place}: clamped without an attenuation, which it is about; give one")
    return FADE[1].read(clamped, place)


def _faded(attenuation: Float[Array, "... 3"], distance: Float[Array, "*n"], held: bool) -> Float[Array, "*n"]:
    """The attenuation, numerator and denominator divided by a far distance, so that no square of it is formed.

    Edge: where it is not `held` at 1 and grows without end, at the light itself, it is 1 with derivative 0.
    """
    a0, a1, a2 = (attenuation[..., k] for k in range(3))
    part = 1 / jnp.maximum(jax.lax.stop_gradient(distance), 1)
    total = a0 * part + (a1 + a2 * distance) * (distance * part)
    fades = total >= part if held else total > 0
    return jnp.where(fades, part / jnp.where(fades, total, 1), 1)
