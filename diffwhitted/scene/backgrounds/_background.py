"""The contract of a background: what a ray sees that meets nothing."""

from abc import abstractmethod
from typing import ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from ...numerics._vector import Vec3
from ...records import Row
from ._surroundings import Surroundings

LIGHTS = Row("lights", "flag", "Does it light surfaces too: k_d, and a k_h that is stated?", default=True)
"""The row of backgrounds that can light surfaces."""


class AbstractBackground(eqx.Module):
    """What surrounds the scene. A new kind states `TYPE`, `ROWS`, `seen`, and its fields with their
    checks; `__init__` takes the rows by their names, and `place`, which is what messages call the record."""

    TYPE: ClassVar[str]
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {}
    ROWS: ClassVar[tuple[Row, ...]]
    SHORT: ClassVar[bool] = False
    """Files have a form for it without a type."""
    KEYED: ClassVar[bool] = False
    """Files know it by its key, which is called as the type, and state no type."""

    @abstractmethod
    def seen(self, direction: Vec3) -> Vec3:
        """Linear RGB along unit directions; differentiable."""

    def brightest(self) -> np.ndarray:
        """The most light along any direction, (3,), linear RGB; infinite where none is known."""
        return np.full(3, np.inf)

    def brightest_mean(self) -> np.ndarray:
        """The most of its mean about any direction, weighted by a lobe, as `surroundings` finds it."""
        return self.brightest()

    def mean(self, direction: Vec3, steps: tuple[Vec3, Vec3], wanted: Bool[Array, "n"]) -> Vec3:
        """Its mean over the pixels along whose sides the direction changes by `steps`, for the rays that want it."""
        return self.seen(direction)

    def tabled(self) -> "AbstractBackground":
        """The form in which the ray tree reads it."""
        return self

    @property
    def lights_surfaces(self) -> bool:
        """Has it `surroundings`?"""
        return False

    def surroundings(self, shiny: Bool[Array | np.ndarray, "materials"]) -> Surroundings | None:
        """How it lights surfaces, in highlights those of `shiny` materials; None where it does not."""
        return None

    def plain(self) -> "AbstractBackground":
        """What takes its place where its variation is left out, to find what that costs; itself where it has none."""
        return self

    @property
    def varies(self) -> bool:
        """Does it hang on the direction?"""
        return type(self).plain is not AbstractBackground.plain

    def written_type(self) -> str:
        return self.TYPE
