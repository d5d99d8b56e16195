"""The contract of an object: a named shape of one material."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import AbstractSurfaces
from ..numerics._vector import Vec3
from ..records import Row, moved, stacked


class AbstractObject(eqx.Module):
    """What is there.

    A new shape states `TYPE`, `ROWS`, `FAMILY`, `family`, and its fields with their checks.

    `name` and `material` are static fields (`eqx.field(static=True)`); `__init__` takes them, the rows by their names,
    and `place`, which is what messages call the record."""

    TYPE: ClassVar[str]
    """What scene files call it."""
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {}
    """Other names that files may use for it, each with narrower rows."""
    ROWS: ClassVar[tuple[Row, ...]]
    FAMILY: ClassVar[type[AbstractSurfaces]]
    CONVEX: ClassVar[bool] = False
    """A ray that leaves its outer side does not meet it again, and one that leaves its inner side meets nothing else
    of it before the way out.
    """

    ROUND: ClassVar[bool] = False
    """It is its own bounding sphere."""
    FLAT: ClassVar[bool] = False
    """It lies in one plane, and so never stands between its own points and a light."""
    HAS_UV: ClassVar[bool] = False
    """Its points have texture coordinates of their own."""

    name: eqx.AbstractVar[str]
    material: eqx.AbstractVar[str]

    @classmethod
    @abstractmethod
    def family(cls, *columns) -> AbstractSurfaces:
        """The surfaces, from the stacked numbers of the rows, in their order; differentiable."""

    @classmethod
    def columns(cls, objects: Sequence["AbstractObject"]) -> list:
        """The numbers of each row, stacked over the objects."""
        return [stacked([getattr(thing, row.name) for thing in objects]) for row in cls.ROWS if row.numeric]

    def written_type(self) -> str:
        """What a file calls this very record."""
        return self.TYPE

    def size(self) -> Float[Array, ""]:
        """What decides which of two nested solids lies inside: the smaller one. By default the radius of its bounding
        sphere.
        """
        return self.alone().bounding()[1][0]

    def moved(self, by: np.ndarray) -> "AbstractObject":
        """The same, moved by so many metres, (3,). By default the rows of vectors in metres are its places."""
        return moved(self, by)

    def alone(self) -> AbstractSurfaces:
        """The family of this object only."""
        return self.family(*self.columns([self]))

    def ball(self) -> tuple[np.ndarray, float]:
        """Middle (3,) and radius of a sphere around it, float64; the radius is infinite where none is known."""
        middle, radius = self.alone().bounding()
        return np.asarray([float(c[0]) for c in (middle.x, middle.y, middle.z)]), float(radius[0])

    def half_space(self) -> tuple[np.ndarray, float] | None:
        """Unit normal (3,) and offset of the half space that it fills, where it is one."""
        return None

    def away_from(self, place: np.ndarray) -> float:
        """How far its surface is from a point (3,), at least; by default by its bounding sphere, infinite without."""
        middle, radius = self.ball()
        return max(0.0, float(np.linalg.norm(middle - place)) - radius) if np.isfinite(radius) else np.inf

    def flat(self) -> tuple[np.ndarray, float, np.ndarray | None] | None:
        """Unit outward normal (3,) and offset of the plane in which it lies, and its corners (v, 3), None where it has
        no end; None of what is not flat, or does not say.
        """
        return None

    def holds(self, place) -> bool:
        """Is the point (3,) inside the volume that it bounds?"""
        x, y, z = (jnp.asarray([c], float) for c in np.asarray(place, np.float64))
        return bool(self.alone().contains(Vec3(x, y, z))[0])
