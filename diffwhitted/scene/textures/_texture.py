"""The contract of a texture: a pattern that multiplies a coefficient, or whose slopes bend the normal."""

from abc import abstractmethod
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ...numerics._vector import Vec3
from ...records import Row, members_at


class TexturePoint(eqx.Module):
    """Where a texture is asked for its colour; or, of the same form, how that changes from one side of a pixel to the
    other.
    """

    position: Vec3
    """Metres, in the frame of the scene."""
    normal: Vec3
    """Unit, on either side of the surface."""
    uv: tuple[Float[Array, "*n"], Float[Array, "*n"]] | None = None
    """Coordinates that the object brings along; None where no object of the scene has any."""


class AbstractTexture(eqx.Module):
    """A pattern. A new kind states `TYPE`, `ROWS`, `at`, and its fields with their checks; `__init__` takes the rows by
    their names, and `place`, which is what messages call the record.

    Textures of one kind are stacked; for each ray the one that it needs is looked up (`chosen`), so all fields have the
    shape of one texture with the rays as a leading axis.
    """

    TYPE: ClassVar[str]
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {}
    ROWS: ClassVar[tuple[Row, ...]]
    FOOTPRINT: ClassVar[bool] = False
    """Its mean over a footprint is stated."""
    SLOPED: ClassVar[bool] = False
    """Its colour changes smoothly, so that it may be a height (see `slopes`)."""

    @property
    def needs_uv(self) -> bool:
        """Does it need the coordinates of the object that wears it?"""
        return False

    @abstractmethod
    def at(self, point: TexturePoint) -> Vec3:
        """Linear RGB at the points; differentiable."""

    def tabled(self) -> "AbstractTexture":
        """The form in which the ray tree reads it, of fields that stack."""
        return self

    def chosen(self, which: Int[Array, "n"]) -> "AbstractTexture":
        """Of stacked textures, the one that each ray needs."""
        return members_at(self, which)

    def moved(self, by: np.ndarray) -> "AbstractTexture":
        """The pattern moved by so many metres, (3,); itself where it does not depend on where the origin is."""
        return self

    def brightest(self) -> np.ndarray:
        """The most in each channel, (3,); infinite where none is known."""
        return np.full(3, np.inf)

    def mean(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint]) -> Vec3:
        """Linear RGB, averaged over a small pixel; the point changes by `steps` along its sides."""
        return self.at(point)

    def mean_in_perspective(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint], slant) -> Vec3:
        """Linear RGB, averaged over the pixel in which the point is (steps_u u + steps_v v) / (1 + slant_u u +
        slant_v v) away from its middle, u and v from -1/2 to 1/2.
        """
        return self.at(point)

    def softened(self, point: TexturePoint, width: Float[Array, "*n"]) -> Vec3:
        """Linear RGB, about the mean over so many metres of the surface around each point."""
        return self.at(point)

    def slopes(
        self, point: TexturePoint, width: Float[Array, "*n"], along: tuple[TexturePoint, ...]
    ) -> tuple[Float[Array, "*n"], ...]:
        """How much the mean of the three channels rises along each change of the point; differentiable.

        `width`: metres of the surface over which it is softened.
        """

        def height(point: TexturePoint) -> Float[Array, "*n"]:
            colour = self.softened(point, width)
            return (colour.x + colour.y + colour.z) / 3

        together = jax.tree.map(lambda *steps: jnp.stack(steps), *along)
        rises = jax.vmap(lambda step: jax.jvp(height, (point,), (step,))[1])(together)
        return tuple(rises[k] for k in range(len(along)))

    def varies(
        self,
        point: TexturePoint,
        steps: tuple[TexturePoint, TexturePoint],
        slant: tuple[Float[Array, "*n"], Float[Array, "*n"]],
    ) -> tuple[Bool[Array, "*n"], Bool[Array, "*n"]]:
        """Where `mean`, and where `mean_in_perspective`, is needed for the colour of such a pixel."""
        no = jnp.zeros(point.position.shape, bool)
        return no, no

    def written_type(self) -> str:
        return self.TYPE
