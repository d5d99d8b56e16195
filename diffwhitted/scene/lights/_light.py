"""The contract of a light: where its light comes from and how much of it arrives."""

from abc import abstractmethod
from typing import ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from ...numerics._vector import Vec3
from ...records import Row, moved
from ._border import Borders


class AbstractLight(eqx.Module):
    """A source of light. A new kind states `TYPE`, `ROWS`, `arriving`, and its fields with their checks.

    `name` is a static field (`eqx.field(static=True)`); `__init__` takes the rows by their names, `name`, and `place`,
    which is what messages call the record."""

    TYPE: ClassVar[str]
    """What scene files call it."""
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {}
    ROWS: ClassVar[tuple[Row, ...]]

    name: eqx.AbstractVar[str | None]
    """None: the scene numbers it (light_1, light_2, ...)."""

    @abstractmethod
    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """Unit direction to the light, its distance (metres, infinite for one at infinity), and the colour that
        arrives unless occluded; differentiable.
        """

    def borders(self, point: Vec3) -> Borders:
        """The edges of its light at points, which `arriving` knows nothing of; differentiable. By default none."""
        del point
        return ()

    @property
    def bordered(self) -> bool:
        """Has its light edges at all?"""
        return False

    def without_borders(self) -> "AbstractLight":
        """The same light to all sides."""
        return self

    def members(self) -> tuple["AbstractLight", ...]:
        """What the ray tree sees in its place, differentiable in its numbers. By default the light itself."""
        return (self,)

    def ball_radius(self) -> Float[Array, "*one"] | None:
        """Radius (metres) of the ball about its middle by which one ray decides how much of it is seen (see
        `SphereLight`); None: a shadow ray sees it or not.
        """
        return None

    @property
    def sized(self) -> bool:
        """Has it a size, so that `samples` decides how its half shadows are found?"""
        return type(self).sampled is not AbstractLight.sampled

    def without_size(self) -> "AbstractLight":
        """The same light from one point."""
        return self

    def sampled(self, samples: int) -> "AbstractLight":
        """The same light by so many points, 0 for one ray, where it has a size."""
        del samples
        return self

    def brightest(self) -> np.ndarray:
        """The most light that may arrive anywhere, (3,), linear RGB; infinite where none is known."""
        return np.full(3, np.inf)

    def place(self) -> np.ndarray | None:
        """Where it stands, (3,) in metres; None for one that stands outside of everything or at no one place."""
        return None

    def moved(self, by: np.ndarray) -> "AbstractLight":
        """The same, moved by so many metres, (3,). By default the rows of vectors in metres are its places."""
        return moved(self, by)

    @property
    def outside(self) -> bool:
        """It is certain to stand outside of any bounded body."""
        return False

    @property
    def fades(self) -> bool:
        """Does its light get less with the distance?"""
        return False

    def held_within(self) -> float:
        """How near (metres) its fade is held at 1, where it would make more of its colour; 0 for nowhere."""
        return 0.0

    def without_fading(self) -> "AbstractLight":
        """The same light, arriving in full."""
        return self

    def written_type(self) -> str:
        return self.TYPE


COLOUR = Row("colour", "colour", "Linear RGB.", lowest=0)
