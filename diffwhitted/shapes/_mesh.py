"""Triangle meshes: one object of many triangles, from arrays or from a file."""

from collections.abc import Sequence
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import AbstractSurfaces
from ..numerics._vector import vec3
from ..records import Row, changed, is_traced
from ._facets import (
    as_triangles,
    checked_faces,
    closes,
    flat_normals,
    mean_normals,
    of_unit_length,
    signed_volume,
)  # fmt: skip
from ._mesh_file import read_mesh
from ._mesh_sides import shared_sides
from ._object import SHADING, AbstractObject, joined, same_numbers
from ._pose import by_rows
from ._triangles import Triangles


class Mesh(AbstractObject):
    """A triangle mesh, by vertices and faces or by a file (OBJ, PLY, STL, glTF, ...); faces run counter-clockwise seen
    from outside.

    A closed one, whose every side is that of two faces, bounds a volume and may be glass. Raises `SceneError` for a
    file that cannot be read, for a face that names no vertex, for numbers that are not finite, and where nothing is
    left of it.
    """

    TYPE: ClassVar[str] = "mesh"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("vertices", "vectors", "Metres.", unit="m", default=None, count=(3, None), scale="unbounded", moves="rays"),
        Row("faces", "faces", "Numbers of the vertices around each face, from 0, three or more, counter-clockwise seen "
            "from outside.", default=None),
        Row("file", "file", "In place of both: a mesh file, its path from the scene file.", default=None),
        Row("normals", "vectors", "One a vertex, of any length but zero.", default=None, scale="unbounded",
            moves="nothing"),
        Row("uvs", "pairs", "Texture coordinates, one pair a vertex.", default=None, parts=("u", "v"),
            scale="unbounded", moves="patterns"),
        Row("shading", "choice", "flat: the normal of the face; phong: the normals of the vertices, those stated or "
            "the means of the faces around them, interpolated; fast_phong: the same normal by its Taylor series about "
            "the middle of the triangle; gouraud: the light of lamps at the vertices, interpolated. Default: phong "
            "where normals are stated, else flat.", default=None, choices=SHADING,
            source="Hearn and Baker (14-37) to (14-45)"),
    )  # fmt: skip
    INTERPOLATES: ClassVar[bool] = True
    FAMILY: ClassVar[type[AbstractSurfaces]] = Triangles

    vertices: Float[Array, "v 3"]
    faces: Any
    """(f, 3), whole numbers."""
    normals: Float[Array, "v 3"] | None
    uvs: Float[Array, "v 2"] | None
    shading: str = eqx.field(static=True)
    file: str | None = eqx.field(static=True)
    closed: bool = eqx.field(static=True)
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(
        self,
        name: str,
        vertices=None,
        faces=None,
        material: str = "",
        *,
        file: str | None = None,
        normals=None,
        uvs=None,
        shading: str | None = None,
        place: str | None = None,
    ):
        place = place or f"object {name!r}"
        self.name, self.material, self.file = name, material, None if file is None else str(file)
        rows = {row.name: row for row in self.ROWS}
        if file is not None and vertices is None and faces is None:
            vertices, faces, of_file, at_file = read_mesh(str(file), place)
            normals, uvs = of_file if normals is None else normals, at_file if uvs is None else uvs
        if vertices is None or faces is None:
            raise SceneError(f"{place}: a mesh needs vertices and faces, or a file; state one of the two ways")
        if shading not in (None, *SHADING):
            raise SceneError(f"{place}: shading = {shading!r}; allowed is {', '.join(SHADING)}")
        # Take the numbers, and triangles in place of longer faces.
        self.vertices = rows["vertices"].read(vertices, place)
        checked = checked_faces(faces, len(self.vertices), place)
        known = not is_traced(self.vertices)
        self.faces = as_triangles(checked, np.asarray(self.vertices, np.float64) if known else None, place)
        self.closed = closes(np.asarray(self.vertices) if known else None, self.faces)
        self.normals = None if normals is None else rows["normals"].read(normals, place)
        self.uvs = None if uvs is None else rows["uvs"].read(uvs, place)
        for key, values in (("normals", self.normals), ("uvs", self.uvs)):
            if values is not None and len(values) != len(self.vertices):
                raise SceneError(
                    f"{place}: {key} has {len(values)} entries for {len(self.vertices)} vertices; "
                    "allowed is one a vertex"
                )
        self.shading = shading or ("flat" if normals is None else "phong")

    def left_out(self) -> tuple[str, ...]:
        """The arrays where they are those of its file, else the file."""
        if self.file is None:
            return ()
        held = {key: getattr(self, key) for key in ("vertices", "faces", "normals", "uvs")}
        return tuple(held) if same_numbers(held, Mesh(self.name, file=self.file)) else ("file",)

    @property
    def surfaces(self) -> int:
        return len(self.faces)

    @property
    def solid(self) -> bool:
        return self.closed

    @property
    def has_uv(self) -> bool:
        return self.uvs is not None

    @property
    def interpolation(self) -> str:
        return self.shading

    def shaded(self, shading: str) -> "Mesh":
        return self if self.shading == "flat" else changed(self, shading=shading)

    @property
    def inside_out(self) -> bool:
        """Do the faces of a closed mesh run clockwise seen from outside? False where that is not known."""
        if not self.closed or is_traced(self.vertices):
            return False
        return signed_volume(np.asarray(self.vertices, np.float64), np.asarray(self.faces)) < 0

    def transformed(self, linear, shift, place: str) -> "Mesh":
        """Vertices go along, and normals stay square to the faces: by the transposed inverse."""
        there = by_rows(self, linear, shift, place)
        if self.normals is None:
            return there
        inverse = (jnp if is_traced(linear) else np).linalg.inv(linear)
        return changed(there, normals=self.normals @ inverse)

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """Corners (n, 3, 3) of all triangles, normals at them where a mesh has any, texture coordinates likewise."""
        corners = joined([thing.vertices[thing.faces] for thing in objects])
        if all(thing.shading == "flat" for thing in objects):
            normals = None
        else:
            normals = joined([thing.corner_normals() for thing in objects])
        if all(thing.uvs is None for thing in objects):
            return [corners, normals, None]
        uvs = [np.zeros((len(t.faces), 3, 2), corners.dtype) if t.uvs is None else t.uvs[t.faces] for t in objects]
        return [corners, normals, joined(uvs)]

    @classmethod
    def sides(cls, objects: Sequence[Any]):
        return shared_sides(objects)

    def corner_normals(self) -> Any:
        """Unit normals at the corners of the triangles, (f, 3, 3), differentiable."""
        if self.shading == "flat":
            flat = flat_normals(self.vertices, self.faces)[:, None, :]
            xp: Any = jnp if is_traced(flat) else np
            return xp.repeat(flat, 3, axis=1)
        if self.normals is not None:
            return of_unit_length(self.normals)[self.faces]
        return mean_normals(self.vertices, self.faces)[self.faces]

    @classmethod
    def family(cls, corners, normals=None, uvs=None) -> Triangles:
        def each(columns) -> Any:
            return tuple(vec3(columns[:, k]) for k in range(3))

        places = None if uvs is None else tuple((uvs[:, k, 0], uvs[:, k, 1]) for k in range(3))
        return Triangles(each(corners), None if normals is None else each(normals), places)

    def ball(self) -> tuple[np.ndarray, float]:
        vertices = np.asarray(self.vertices, np.float64)
        middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        return middle, float(np.linalg.norm(vertices - middle, axis=1).max())

    def size(self) -> Float[Array, ""]:
        span = self.vertices.max(axis=0) - self.vertices.min(axis=0)
        return 0.5 * jnp.sqrt(jnp.sum(jnp.asarray(span) ** 2))

    def away_from(self, place: np.ndarray) -> float:
        """From the nearest vertex less the longest side: a bound from below that needs no search."""
        vertices, faces = np.asarray(self.vertices, np.float64), np.asarray(self.faces)
        longest = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=2).max()
        return max(0.0, float(np.linalg.norm(vertices - place, axis=1).min() - longest))

    def holds(self, place) -> bool:
        if not self.closed:
            return False
        # A place outside its box needs no search.
        vertices, there = np.asarray(self.vertices, np.float64), np.asarray(place, np.float64)
        if (there < vertices.min(axis=0)).any() or (there > vertices.max(axis=0)).any():
            return False
        family = self.alone()
        point = vec3(jnp.asarray(np.asarray(place, np.float64), jax.tree.leaves(family)[0].dtype)[None])
        return bool(family.holds(0, self.surfaces, point)[0])
