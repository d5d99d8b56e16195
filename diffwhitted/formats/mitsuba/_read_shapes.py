"""Shapes of Mitsuba, a function a kind."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...scene import PointLight
from ...shapes import read_parts
from ..others import _placed as placed
from ..others._found import Found
from ._read_materials import Bsdfs
from ._tags import Tag, file_beside

SQUARE = np.asarray([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
SQUARE_UV = np.asarray([[0, 0], [1, 0], [1, 1], [0, 1]], float)
AREAS = {"sphere": 4 * np.pi, "rectangle": 4.0, "disk": np.pi}


def _ball(tag: Tag) -> tuple[np.ndarray, float]:
    centre = tag.named("center", "point")
    return np.zeros(3) if centre is None else centre.point(), tag.number("radius", 1.0)


def _sphere(tag: Tag, matrix: np.ndarray, name: str | None, found: Found, bsdfs: Bsdfs, folder: Path) -> None:
    made = placed.sphere(matrix, *_ball(tag))
    found.add(made, name, "sphere", bsdfs.worn(tag, None, solid=True), tag.place)


def _rectangle(tag: Tag, matrix: np.ndarray, name: str | None, found: Found, bsdfs: Bsdfs, folder: Path) -> None:
    corners = placed.at(matrix, SQUARE)
    # Keep the side of +z outside.
    corners, uvs = (corners[::-1], SQUARE_UV[::-1]) if placed.is_mirrored(matrix) else (corners, SQUARE_UV)
    made = placed.polygon(np.eye(4), corners)
    found.add(made, name, "rectangle", bsdfs.worn(tag, (corners, uvs), solid=False), tag.place)


def _disk(tag: Tag, matrix: np.ndarray, name: str | None, found: Found, bsdfs: Bsdfs, folder: Path) -> None:
    made = placed.disc(matrix, np.zeros(3), (0, 0, 1), 1.0)
    found.add(made, name, "disc", bsdfs.worn(tag, None, solid=False), tag.place)


def _cube(tag: Tag, matrix: np.ndarray, name: str | None, found: Found, bsdfs: Bsdfs, folder: Path) -> None:
    made = placed.box(matrix, np.full(3, -1.0), np.ones(3))
    found.add(made, name, "cube", bsdfs.worn(tag, None, solid=True), tag.place)


def _cylinder(tag: Tag, matrix: np.ndarray, name: str | None, found: Found, bsdfs: Bsdfs, folder: Path) -> None:
    """Open, as Mitsuba's is."""
    stated = tag.named("p0", "point"), tag.named("p1", "point")
    usual = np.zeros(3), np.asarray([0.0, 0.0, 1.0])
    base, top = (one if end is None else end.point() for end, one in zip(stated, usual, strict=True))
    radius = tag.number("radius", 1.0)
    made = placed.frustum(matrix, base, top, radius, radius, capped=False)
    found.add(made, name, "cylinder", bsdfs.worn(tag, None, solid=False), tag.place)


def _file(tag: Tag, matrix: np.ndarray, name: str | None, found: Found, bsdfs: Bsdfs, folder: Path) -> None:
    """Triangles of an OBJ, PLY or STL file."""
    path = file_beside(tag, tag.text("filename", ""), folder)
    if path.suffix.lower() not in (".obj", ".ply", ".stl"):
        raise tag.error(f"filename {path.name[:80]!r}; allowed is one that ends with .obj, .ply or .stl")
    flat = tag.truth("face_normals", False)
    for part in read_parts(str(path), tag.place):
        normals = None if flat else part.normals
        if normals is not None and _are_flat(part.vertices, part.faces, normals):
            normals = None
        made = placed.mesh(matrix, part.vertices, part.faces, normals, part.uvs)
        corners = None if part.uvs is None else (placed.at(matrix, part.vertices), part.uvs)
        closed = _is_closed(part.vertices, part.faces)
        found.add(made, name or path.stem, "mesh", bsdfs.worn(tag, corners, solid=closed), tag.place)


def _are_flat(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> bool:
    """All corners of each triangle have the triangle's own normal."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), np.finfo(float).tiny)
    return bool((np.einsum("fkc,fc->fk", normals[faces], across) > 1 - 1e-6).all())


def _is_closed(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Each side of a triangle is that of another, the other way round; corners in one place are one."""
    _, same = np.unique(np.round(vertices, 6), axis=0, return_inverse=True)
    corners = same.reshape(-1)[faces]
    sides = np.concatenate([corners[:, [k, (k + 1) % 3]] for k in range(3)])
    there = set(map(tuple, sides.tolist()))
    return all((b, a) in there for a, b in there)


SHAPES: dict[str, Callable[..., None]] = {
    "sphere": _sphere,
    "rectangle": _rectangle,
    "disk": _disk,
    "cube": _cube,
    "cylinder": _cylinder,
    "obj": _file,
    "ply": _file,
    "stl": _file,
}


def lamp_of(tag: Tag, matrix: np.ndarray, radiance: np.ndarray, name: str) -> PointLight | None:
    """In place of a small shape that shines, a point in its middle: as bright straight ahead at a distance, where it
    seems of the area A (of a ball pi r^2), as the intensity A L.
    """
    growth = placed.even_growth(matrix)
    if tag.type == "sphere":
        centre, radius = _ball(tag)
        if growth is None:
            return None
        return _lamp(placed.at(matrix, centre), np.pi * (growth * radius) ** 2 * radiance, name, tag)
    if tag.type in ("rectangle", "disk"):
        first, second = placed.linear(matrix)[:, 0], placed.linear(matrix)[:, 1]
        area = AREAS[tag.type] * float(np.linalg.norm(np.cross(first, second)))
        return _lamp(placed.shift(matrix), area * radiance, name, tag)
    return None


def _lamp(where: np.ndarray, intensity: np.ndarray, name: str, tag: Tag) -> PointLight:
    return PointLight(where, intensity / np.pi, (0, 0, 1), name, tag.place, "none")
