"""The contract of a texture: a pattern that multiplies a coefficient."""

from abc import abstractmethod
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ...numerics._vector import Vec3
from ...records import Row


class AbstractTexture(eqx.Module):
    """A pattern. A new kind states `TYPE`, `ROWS`, `at`, and its fields with their checks; `__init__` takes the rows by
    their names, and `place`, which is what messages call the record.

    Textures of one kind are stacked; for each ray the one that it needs is looked up, so all fields have the shape of
    one texture with the rays as a leading axis.
    """

    TYPE: ClassVar[str]
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {}
    ROWS: ClassVar[tuple[Row, ...]]
    FOOTPRINT: ClassVar[bool] = False
    """Its mean over a footprint is stated."""

    @abstractmethod
    def at(self, point: Vec3) -> Vec3:
        """Linear RGB at the points (in metres, in the frame of the scene); differentiable."""

    def moved(self, by: np.ndarray) -> "AbstractTexture":
        """The pattern moved by so many metres, (3,); itself where it does not depend on where the origin is."""
        return self

    def brightest(self) -> np.ndarray:
        """The most in each channel, (3,); infinite where none is known."""
        return np.full(3, np.inf)

    def mean(self, point: Vec3, steps: tuple[Vec3, Vec3]) -> Vec3:
        """Linear RGB, averaged over a small pixel; the point changes by `steps` along its sides."""
        return self.at(point)

    def mean_in_perspective(self, point: Vec3, steps: tuple[Vec3, Vec3], slant) -> Vec3:
        """Linear RGB, averaged over the pixel in which the point is (steps_u u + steps_v v) / (1 + slant_u u +
        slant_v v) away from its middle, u and v from -1/2 to 1/2.
        """
        return self.at(point)

    def varies(
        self, point: Vec3, steps: tuple[Vec3, Vec3], slant: tuple[Float[Array, "*n"], Float[Array, "*n"]]
    ) -> tuple[Bool[Array, "*n"], Bool[Array, "*n"]]:
        """Where `mean`, and where `mean_in_perspective`, is needed for the colour of such a pixel."""
        no = jnp.zeros(point.shape, bool)
        return no, no

    def written_type(self) -> str:
        return self.TYPE
