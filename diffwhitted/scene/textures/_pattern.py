"""The contract of a pattern that is a smooth number from 0 to 1 at each point: two colours mixed, or a height."""

from abc import abstractmethod
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._safe import safe_sqrt
from ...numerics._vector import Vec3, dot, vec3
from ...records import Row, number_array, require
from ._texture import AbstractTexture, TexturePoint

COLOURS = Row("colours", "colours", "Two linear RGB colours, of 0 and of 1.", lowest=0, count=(2, 2),
              default=((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), fit_bounds=(0.0, 1.0))  # fmt: skip
AXES = Row("axes", "text", "The axes along which it changes.", default="xyz", pattern="^[xyz]{1,3}$")
SMALL = 0.1
"""Of the shortest length of a pattern: over a smaller footprint it hardly changes."""


class AbstractPattern(AbstractTexture):
    """A number v from 0 to 1, by which the first colour goes over into the second. A new pattern states `TYPE`, `ROWS`
    (`COLOURS` and its own), `number` and `finest`.
    """

    FOOTPRINT: ClassVar[bool] = True
    SLOPED: ClassVar[bool] = True

    colours: eqx.AbstractVar[Float[Array, "2 3"]]

    @abstractmethod
    def number(self, position: Vec3, width: Float[Array, "*n"] | None) -> Float[Array, "*n"]:
        """v at the points, twice differentiable; or about its mean over so many metres around each."""

    @abstractmethod
    def finest(self) -> Float[Array, "..."]:
        """The shortest length over which it changes, metres."""

    def at(self, point: TexturePoint) -> Vec3:
        return self._mixed(self.number(point.position, None))

    def mean(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint]) -> Vec3:
        return self._mixed(self.number(point.position, self._width(steps)))

    def mean_in_perspective(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint], slant) -> Vec3:
        """As `mean`: the pattern is taken as even over a pixel."""
        return self.mean(point, steps)

    def varies(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint], slant):
        much = self._width(steps) > SMALL * self.finest()
        return much, jnp.zeros_like(much)

    def brightest(self) -> np.ndarray:
        """The larger of the two colours in each channel, (3,)."""
        return np.asarray(self.colours, np.float64).max(axis=0)

    def softened(self, point: TexturePoint, width: Float[Array, "*n"]) -> Vec3:
        return self._mixed(self.number(point.position, width))

    def _width(self, steps: tuple[TexturePoint, TexturePoint]) -> Float[Array, "*n"]:
        return safe_sqrt(jnp.maximum(*(dot(step.position, step.position) for step in steps)))

    def _mixed(self, number: Float[Array, "*n"]) -> Vec3:
        first, second = vec3(self.colours[..., 0, :]), vec3(self.colours[..., 1, :])
        return first * (1 - number) + second * number


def read_colours(colours, place: str) -> Float[Array, "2 3"]:
    array = number_array(colours, place, "colours", ((2, 3),))
    require(lambda c: (c >= 0).all(), place, "colours", array, ">= 0")
    return array


def read_axes(axes: str, place: str) -> str:
    if not axes or len(set(axes)) != len(axes) or set(axes) - set("xyz"):
        raise SceneError(f'{place}: axes = {axes!r}; allowed are some of the letters x, y, z, such as "xz"')
    return axes


def left_of_wave(length: Float[Array, "..."] | float, width: Float[Array, "*n"] | None) -> Float[Array, "*n"] | float:
    """What a box of a width leaves of a wave of a length: exp(-(pi width / length)**2 / 6), that of a Gaussian of the
    same variance, which has no sign to change.
    """
    if width is None:
        return 1.0
    part = jnp.pi * width / length
    return jnp.exp(-jnp.minimum(part * part / 6, 80.0))
