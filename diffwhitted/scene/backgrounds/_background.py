"""The contract of a background: what a ray sees that meets nothing."""

from abc import abstractmethod
from typing import ClassVar

import equinox as eqx
import numpy as np

from ...numerics._vector import Vec3
from ...records import Row


class AbstractBackground(eqx.Module):
    """What surrounds the scene. A new kind states `TYPE`, `ROWS`, `seen`, and its fields with their
    checks; `__init__` takes the rows by their names, and `place`, which is what messages call the record."""

    TYPE: ClassVar[str]
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {}
    ROWS: ClassVar[tuple[Row, ...]]
    SHORT: ClassVar[bool] = False
    """Files have a form for it without a type."""

    @abstractmethod
    def seen(self, direction: Vec3) -> Vec3:
        """Linear RGB along unit directions; differentiable."""

    def brightest(self) -> np.ndarray:
        """The most light along any direction, (3,), linear RGB; infinite where none is known."""
        return np.full(3, np.inf)

    def plain(self) -> "AbstractBackground":
        """What takes its place where its variation is left out, to find what that costs; itself where it has none."""
        return self

    @property
    def varies(self) -> bool:
        """Does it hang on the direction?"""
        return type(self).plain is not AbstractBackground.plain

    def written_type(self) -> str:
        return self.TYPE
