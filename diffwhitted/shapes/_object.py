"""The contract of an object: a named shape of one material."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import AbstractSurfaces
from ..numerics._vector import Vec3
from ..records import Row, changed, in_dtype, is_traced, moved, stacked
from ._pose import NAMES, POSE, VELOCITY, affine, by_rows, has_pose, stated_pose

SHADING = ("flat", "gouraud", "fast_phong", "phong")
"""How light is interpolated over triangles: not at all, the light itself, or the normal, by a series or as it is."""


class AbstractObject(eqx.Module):
    """What is there.

    A new shape states `TYPE`, `ROWS`, `FAMILY`, `family`, and its fields with their checks.

    `name` and `material` are static fields (`eqx.field(static=True)`); `__init__` takes them, the rows by their names,
    and `place`, which is what messages call the record. The keys of `POSE` and `VELOCITY` every shape has without
    stating them."""

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
    INTERPOLATES: ClassVar[bool] = False
    """Its surfaces have corners, between which light is interpolated (see `interpolation`)."""
    FLAT: ClassVar[bool] = False
    """It lies in one plane, and so never stands between its own points and a light."""

    CLEAR: ClassVar[bool] = True
    """It may let light through."""

    name: eqx.AbstractVar[str]
    material: eqx.AbstractVar[str]
    scale: Float[Array, "*three"] | None = eqx.field(default=None, kw_only=True)
    rotate_deg: Float[Array, "3"] | None = eqx.field(default=None, kw_only=True)
    translate: Float[Array, "3"] | None = eqx.field(default=None, kw_only=True)
    matrix: Float[Array, "4 4"] | None = eqx.field(default=None, kw_only=True)
    velocity: Float[Array, "3"] | None = eqx.field(default=None, kw_only=True)

    def __new__(cls, *values, **keys):
        """Every field is there from the start: equinox counts them to tell a record from a wrapped function."""
        self = super().__new__(cls)
        for name in (*NAMES, VELOCITY.name):
            object.__setattr__(self, name, None)
        return self

    def __init_subclass__(cls, **keys):
        super().__init_subclass__(**keys)
        if "ROWS" in cls.__dict__:
            cls.ROWS = (*cls.ROWS, *POSE, VELOCITY)
        if "ALSO" in cls.__dict__:
            cls.ALSO = {name: (*rows, *POSE, VELOCITY) for name, rows in cls.ALSO.items()}

    @classmethod
    @abstractmethod
    def family(cls, *columns) -> AbstractSurfaces:
        """The surfaces, from the stacked numbers of the rows, in their order; differentiable."""

    def moving(self, velocity, place: str | None = None):
        """The same, moving by so many metres a second, (3,), while the shutter of a camera is open; None: at rest.

        Raises `SceneError` for what is none.
        """
        if velocity is None and self.velocity is None:
            return self
        place = place or f"object {self.name!r}"
        return changed(self, velocity=None if velocity is None else VELOCITY.read(velocity, place))

    @classmethod
    def columns(cls, objects: Sequence["AbstractObject"]) -> list:
        """The numbers of each row, stacked over the objects."""
        rows = [row for row in cls.ROWS if row.numeric and row.name not in (*NAMES, VELOCITY.name)]
        return [stacked([getattr(thing, row.name) for thing in objects]) for row in rows]

    @classmethod
    def sides(cls, objects: Sequence["AbstractObject"]) -> tuple[np.ndarray, np.ndarray] | None:
        """Of a family that is `SIDED`, which of its surfaces meet where (see `Triangles.sides`)."""
        del objects
        return None

    def placed(self, *, scale=None, rotate_deg=None, translate=None, matrix=None, place: str | None = None):
        """The same, scaled about the origin by a number or three, then turned about x, y and z by degrees, then moved
        by metres; or all of it by a matrix (4, 4), whose last row is 0, 0, 0, 1. In place of any transform before.

        Raises `SceneError` for a value that is not allowed, and for what makes of the shape one that has no name.
        """
        place = place or f"object {self.name!r}"
        stated = stated_pose(place, scale=scale, rotate_deg=rotate_deg, translate=translate, matrix=matrix)
        there = changed(self, **stated)
        there.as_placed(place)
        return there

    def as_placed(self, place: str | None = None):
        """The same without a transform: its own numbers are those of where it is. Differentiable."""
        if not has_pose(self):
            return self
        bare = changed(self, **dict.fromkeys(NAMES))
        there = self.transformed(*affine(self), place or f"object {self.name!r}")
        real = [leaf for leaf in jax.tree.leaves(bare) if jnp.issubdtype(leaf.dtype, jnp.floating)]
        return in_dtype(changed(there, **dict.fromkeys(NAMES), velocity=self.velocity), jnp.result_type(*real))

    def transformed(self, linear, shift, place: str) -> "AbstractObject":
        """The same where each of its points p has become `linear` p + `shift`, (3, 3) and (3,). By default its rows
        say what becomes of them.
        """
        return by_rows(self, linear, shift, place)

    def is_convex(self) -> bool:
        """`CONVEX`, of this very object."""
        return self.CONVEX

    @property
    def surfaces(self) -> int:
        """Of how many surfaces of its family it consists."""
        return 1

    @property
    def solid(self) -> bool:
        """Does it bound a volume, which may be a medium?"""
        return self.FAMILY.SOLID

    @property
    def has_uv(self) -> bool:
        """Have its points texture coordinates of their own?"""
        return False

    @property
    def interpolation(self) -> str | None:
        """How light is interpolated over its surfaces, a word of `SHADING`; None where these have no corners."""
        return None

    def shaded(self, shading: str) -> "AbstractObject":
        """The same with another `interpolation`, where it has one and is not flat."""
        del shading
        return self

    def written_type(self) -> str:
        """What a file calls this very record."""
        return self.TYPE

    def left_out(self) -> tuple[str, ...]:
        """The keys that a scene file need not state, as another one says the same."""
        return ()

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
        return self.family(*jax.tree.map(jnp.asarray, self.columns([self])))

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
        """Is the point (3,) inside the volume that it bounds? Outside of its bounding sphere no one needs to ask."""
        middle, radius = self.ball()
        if np.linalg.norm(middle - np.asarray(place, np.float64)) > radius:
            return False
        x, y, z = (jnp.asarray([c], float) for c in np.asarray(place, np.float64))
        return bool(self.alone().contains(Vec3(x, y, z))[0])


def joined(parts: Sequence):
    """Arrays of several objects one after the other, on the host where all of them are known."""
    if any(map(is_traced, parts)):
        return jnp.concatenate([jnp.asarray(part) for part in parts])
    return np.asarray(parts[0]) if len(parts) == 1 else np.concatenate(list(map(np.asarray, parts)))


def same_numbers(held: dict, other: AbstractObject) -> bool:
    """Are these arrays those of the same names in another record, in their own precision?"""
    for key, mine in held.items():
        theirs = getattr(other, key)
        if (mine is None) != (theirs is None):
            return False
        if mine is not None and not np.array_equal(np.asarray(theirs).astype(mine.dtype), np.asarray(mine)):
            return False
    return True
