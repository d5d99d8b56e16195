"""Bicubic patches: one object of one or more, from their control points or from a file."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import AbstractSurfaces
from ..records import Row, check_file
from ._object import AbstractObject, joined, same_numbers
from ._patches import CELLS, Patches, patches_of

FILES = (".json", ".bpt")
MOST = 4096
"""Patches; of more the grids would not fit into the memory that the limits of a picture are made for."""


class Patch(AbstractObject):
    """Bicubic Bezier patches by 4 x 4 control points each, metres, or by a file: JSON with `vertices` and `patches`,
    each 4 x 4 numbers of vertices, or .bpt.

    A sheet, whose outer side is that of dS/du x dS/dv: u runs along the rows, v from row to row. Raises `SceneError`
    for a file that cannot be read, for other than 16 points a patch, and for more than 4096 patches.
    """

    TYPE: ClassVar[str] = "patch"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("control_points", "vectors", "Metres: 16 a patch, row by row; u runs along a row, v from row to row.",
            unit="m", default=None, count=(16, None), grid=True, scale="unbounded", moves="rays",
            source="Whitted 1980, section 3"),
        Row("file", "file", "In place of them: a .json file with vertices and patches (4 x 4 numbers of vertices "
            "each), or a .bpt file; its path from the scene file.", default=None),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Patches
    CLEAR: ClassVar[bool] = False

    control_points: Float[Array, "points 3"]
    """16 a patch."""
    file: str | None = eqx.field(static=True)
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(
        self, name: str, control_points=None, material: str = "", *, file: str | None = None, place: str | None = None
    ):
        place = place or f"object {name!r}"
        self.name, self.material, self.file = name, material, None if file is None else str(file)
        if file is not None and control_points is None:
            control_points = _read(Path(file), place)
        if control_points is None:
            raise SceneError(f"{place}: a patch needs control_points, or a file; state one of the two")
        shape = np.shape(control_points)
        if len(shape) > 2 and shape[-3:] == (4, 4, 3):
            xp: Any = jnp if isinstance(control_points, jnp.ndarray) else np
            control_points = xp.reshape(xp.asarray(control_points), (-1, 3))
        self.control_points = self.ROWS[0].read(control_points, place)
        if len(self.control_points) % 16:
            raise SceneError(
                f"{place}: control_points has {len(self.control_points)} points; allowed is 16 for each patch, four "
                "rows of four"
            )
        if len(self.control_points) > 16 * MOST:
            raise SceneError(
                f"{place}: it has {len(self.control_points) // 16:,} patches; allowed are {MOST:,}. Share them among "
                "several objects, or use a mesh"
            )

    def left_out(self) -> tuple[str, ...]:
        """The points where they are those of its file, else the file."""
        if self.file is None:
            return ()
        held = {"control_points": self.control_points}
        return tuple(held) if same_numbers(held, Patch(self.name, file=self.file)) else ("file",)

    @property
    def surfaces(self) -> int:
        return len(self.control_points) // 16 * 2 * CELLS * CELLS

    @property
    def has_uv(self) -> bool:
        return True

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """The control points of all patches (patches, 16, 3)."""
        return [joined([thing.control_points for thing in objects]).reshape(-1, 16, 3)]

    @classmethod
    def family(cls, points) -> Patches:
        return patches_of(points)

    def size(self) -> Float[Array, ""]:
        span = self.control_points.max(axis=0) - self.control_points.min(axis=0)
        return 0.5 * jnp.sqrt(jnp.sum(jnp.asarray(span) ** 2))

    def ball(self) -> tuple[np.ndarray, float]:
        """Around the control points, between which a patch lies."""
        points = np.asarray(self.control_points, np.float64)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return middle, float(np.linalg.norm(points - middle, axis=1).max())

    def holds(self, place) -> bool:
        del place
        return False


def _read(file: Path, place: str) -> np.ndarray:
    """The control points in a file, (16 n, 3). Raises `SceneError` that begins with `place`."""
    called = f"{place}: file = {str(file)!r}"
    check_file(file, FILES, called)
    try:
        text = file.read_text(encoding="utf-8")
        points = _of_json(text) if file.suffix.lower() == ".json" else _of_bpt(text)
    except (OSError, KeyError, ValueError, TypeError, IndexError, RecursionError) as error:
        wanted = (
            "an object with vertices [[x, y, z], ...] and patches, each 4 x 4 numbers of vertices from 0"
            if file.suffix.lower() == ".json"
            else "the number of patches and for each a line 3 3 and 16 lines x y z"
        )
        raise SceneError(f"{called}: {type(error).__name__}: {error}; allowed is {wanted}") from None
    if not len(points):
        raise SceneError(f"{called} holds no patch; allowed is one or more")
    return points


def _of_json(text: str) -> np.ndarray:
    held = json.loads(text)
    vertices, patches = np.asarray(held["vertices"], np.float64), np.asarray(held["patches"])
    if vertices.ndim != 2 or vertices.shape[1] != 3 or patches.shape[1:] != (4, 4) or patches.dtype.kind not in "iu":
        raise ValueError(f"vertices of shape {vertices.shape}, patches of shape {patches.shape}")
    if patches.min() < 0 or patches.max() >= len(vertices):
        raise ValueError(f"a patch names vertex {patches.max() if patches.min() >= 0 else patches.min()}")
    return vertices[patches].reshape(-1, 3)


def _of_bpt(text: str) -> np.ndarray:
    words = text.split()
    count, each = int(words[0]), 2 + 3 * 16
    if count < 0 or len(words) != 1 + each * count:
        raise ValueError(f"{count} patches are {each * max(count, 0)} numbers, and {len(words) - 1} are there")
    table = np.asarray(words[1:], np.float64).reshape(count, each)
    if (table[:, :2] != 3).any():
        raise ValueError("a patch is not of degree 3 3")
    return table[:, 2:].reshape(-1, 3)
