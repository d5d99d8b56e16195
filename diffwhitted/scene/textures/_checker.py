"""Checkerboards."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..._errors import SceneError
from ...numerics._coverage import Linear
from ...numerics._vector import Vec3, vec3, where
from ...records import Row, changed, is_traced, number_array, require
from ._square_wave import cell_mean, checker_mean, may_vary
from ._texture import AbstractTexture, TexturePoint


class Checker(AbstractTexture):
    """The first colour where floor(x/s) + floor(y/s) + floor(z/s), over the listed axes, is even."""

    TYPE: ClassVar[str] = "checker"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("colours", "colours", "Two linear RGB colours, even first.", lowest=0, count=(2, 2), fit_bounds=(0.0, 1.0)),
        Row("size", "number", "Edge s of a cell, metres.", unit="m", default=1.0, lowest=0, excluded=True, scale="log",
            moves="patterns"),
        Row("axes", "text", "The axes that are counted.", default="xyz", pattern="^[xyz]{1,3}$"),
    )  # fmt: skip
    FOOTPRINT: ClassVar[bool] = True

    colours: Float[Array, "2 3"]
    size: Float[Array, ""]
    corner: Float[Array, "3"]
    """Where cells meet: the origin, unless the pattern was moved (less than two cells, after which it repeats)."""
    axes: str = eqx.field(static=True)

    def __init__(self, colours, size=1.0, axes: str = "xyz", place: str = "texture"):
        self.colours = number_array(colours, place, "colours", ((2, 3),))
        require(lambda c: (c >= 0).all(), place, "colours", self.colours, ">= 0")
        self.size = number_array(size, place, "size", ((),))
        require(lambda s: s > 0, place, "size", self.size, "> 0")
        if not axes or len(set(axes)) != len(axes) or set(axes) - set("xyz"):
            raise SceneError(f'{place}: axes = {axes!r}; allowed are some of the letters x, y, z, such as "xz"')
        self.axes = axes
        self.corner = number_array((0.0, 0.0, 0.0), place, "corner", ((3,),))

    def moved(self, by: np.ndarray) -> "Checker":
        """The pattern moved by so many metres, less the whole periods, while the size is known in float64."""
        period = 2 * self.size if is_traced(self.size) else 2 * np.asarray(self.size, np.float64)
        return changed(self, corner=(self.corner + by) % period)

    def at(self, point: TexturePoint) -> Vec3:
        """Linear RGB at the points. The derivative in the point is 0 (an edge has no width here)."""
        cells = sum(jnp.floor(along / self.size) for along in self._along_axes(point.position - self._corner()))
        even = cells - 2 * jnp.floor(cells / 2) == 0
        return where(even, *self._two())

    def brightest(self) -> np.ndarray:
        """The larger of the two colours in each channel, (3,)."""
        return np.asarray(self.colours, np.float64).max(axis=0)

    def mean(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint]) -> Vec3:
        """Linear RGB, averaged over a pixel smaller than a cell; the point changes by `steps` along its sides."""
        return self._mixed(cell_mean(self._waves(point, steps)))

    def mean_in_perspective(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint], slant) -> Vec3:
        """Linear RGB, averaged over the pixel in which the point is (steps_u u + steps_v v) / (1 + slant_u u +
        slant_v v) away from its middle, u and v from -1/2 to 1/2.
        """
        return self._mixed(checker_mean(self._waves(point, steps), slant))

    def varies(
        self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint], slant
    ) -> tuple[Bool[Array, "*n"], Bool[Array, "*n"]]:
        """Where `mean`, and where `mean_in_perspective`, is needed for the colour of such a pixel."""
        return may_vary(self._waves(point, steps), slant)

    def _mixed(self, mean) -> Vec3:
        even, odd = self._two()
        part = 0.5 * (1 + mean)
        return even * part + odd * (1 - part)

    def _two(self) -> tuple[Vec3, Vec3]:
        return vec3(self.colours[..., 0, :]), vec3(self.colours[..., 1, :])

    def _waves(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint]) -> list[Linear]:
        away = (point.position - self._corner(), *(step.position for step in steps))
        vectors = zip(*(self._along_axes(v) for v in away), strict=True)
        return [Linear(*(along / self.size for along in axis)) for axis in vectors]

    def _along_axes(self, vector: Vec3) -> list:
        return [getattr(vector, axis) for axis in self.axes]

    def _corner(self) -> Vec3:
        return vec3(self.corner)
