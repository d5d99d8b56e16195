"""Many spheres of one material as one object, from arrays or from a file."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import AbstractSurfaces
from ..numerics._vector import vec3
from ..records import Row, changed, check_file, is_traced, number_array, require
from ._object import AbstractObject, joined, same_numbers
from ._pose import even_growth
from ._sphere import Spheres

FILES = (".npz", ".csv")


class SphereSet(AbstractObject):
    """Spheres by their centres and radii in metres, or by a file: .npz with `centres` and `radii`, or .csv with the
    columns x, y, z, radius.

    One object: it has one name and one material, and its inside is that of any of them. Raises `SceneError` for a file
    that cannot be read, for radii that are not above 0, and for other than one radius or one for each centre.
    """

    TYPE: ClassVar[str] = "spheres"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("centres", "vectors", "Centres, metres.", unit="m", default=None, scale="unbounded", moves="rays"),
        Row("radii", "list", "Radii, metres: one for each centre, or one number for all.", unit="m", default=None,
            lowest=0, excluded=True, scale="log", moves="rays"),
        Row("file", "file", "In place of both: a .npz or .csv file, its path from the scene file.", default=None),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Spheres

    centres: Float[Array, "n 3"]
    radii: Float[Array, "n"] | Float[Array, ""]
    file: str | None = eqx.field(static=True)
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(
        self,
        name: str,
        centres=None,
        radii=None,
        material: str = "",
        *,
        file: str | None = None,
        place: str | None = None,
    ):
        place = place or f"object {name!r}"
        self.name, self.material, self.file = name, material, None if file is None else str(file)
        if file is not None and centres is None and radii is None:
            centres, radii = _read(Path(file), place)
        if centres is None or radii is None:
            raise SceneError(f"{place}: spheres need centres and radii, or a file; state one of the two ways")
        self.centres = self.ROWS[0].read(centres, place)
        if not len(self.centres):
            raise SceneError(f"{place}: centres is empty; allowed is one sphere or more")
        self.radii = number_array(radii, place, "radii", ((), (len(self.centres),)))
        require(self.ROWS[1].holds, place, "radii", self.radii, "> 0")

    def left_out(self) -> tuple[str, ...]:
        """The arrays where they are those of its file, else the file."""
        if self.file is None:
            return ()
        held = {"centres": self.centres, "radii": self.radii}
        return tuple(held) if same_numbers(held, SphereSet(self.name, file=self.file)) else ("file",)

    @property
    def surfaces(self) -> int:
        return len(self.centres)

    def transformed(self, linear, shift, place: str) -> "SphereSet":
        """Radii grow as all lengths do. Raises `SceneError` for what makes balls of no kind."""
        return changed(
            self, centres=self.centres @ linear.T + shift, radii=self.radii * even_growth(self, linear, place)
        )

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """Centres (n, 3) and radii (n,) of all."""
        return [joined([thing.centres for thing in objects]), joined([thing.each_radius() for thing in objects])]

    def each_radius(self) -> Any:
        """(n,)."""
        xp: Any = jnp if is_traced(self.radii) else np
        return xp.broadcast_to(self.radii, (len(self.centres),))

    @classmethod
    def family(cls, centres, radii) -> Spheres:
        return Spheres(vec3(centres), radii)

    def size(self) -> Float[Array, ""]:
        """The radius of the largest."""
        return jnp.max(self.radii)

    def ball(self) -> tuple[np.ndarray, float]:
        centres, radii = np.asarray(self.centres, np.float64), np.asarray(self.each_radius(), np.float64)[:, None]
        middle = 0.5 * ((centres - radii).min(axis=0) + (centres + radii).max(axis=0))
        return middle, float((np.linalg.norm(centres - middle, axis=1) + radii[:, 0]).max())

    def away_from(self, place: np.ndarray) -> float:
        """From the nearest surface."""
        away = np.linalg.norm(np.asarray(self.centres, np.float64) - place, axis=1)
        return float(abs(away - np.asarray(self.each_radius(), np.float64)).min())

    def holds(self, place) -> bool:
        away = np.linalg.norm(np.asarray(self.centres, np.float64) - np.asarray(place, np.float64), axis=1)
        return bool((away < np.asarray(self.each_radius(), np.float64)).any())


def _read(file: Path, place: str) -> tuple[np.ndarray, np.ndarray]:
    """Centres and radii in a file. Raises `SceneError` that begins with `place`."""
    called = f"{place}: file = {str(file)!r}"
    check_file(file, FILES, called)
    try:
        if file.suffix.lower() == ".npz":
            with np.load(file, allow_pickle=False) as found:
                return np.asarray(found["centres"], np.float64), np.asarray(found["radii"], np.float64)
        with file.open(newline="", encoding="utf-8-sig") as opened:
            rows = list(csv.DictReader(opened, skipinitialspace=True))
        table = np.asarray([[float(row[key]) for key in ("x", "y", "z", "radius")] for row in rows], np.float64)
    except (OSError, KeyError, ValueError, TypeError) as error:
        wanted = "the arrays centres and radii" if file.suffix.lower() == ".npz" else "the columns x, y, z, radius"
        raise SceneError(
            f"{called}: {type(error).__name__}: {error}; allowed are {wanted}, numbers in each of them"
        ) from None
    return table.reshape(-1, 4)[:, :3], table.reshape(-1, 4)[:, 3]
