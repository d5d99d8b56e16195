"""Reading mesh files with trimesh: what is in them as plain arrays, or a clear error."""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._errors import SceneError
from ..records import check_file

MESH_FILES = (".obj", ".ply", ".stl", ".off", ".glb", ".gltf")
MOST_TRIANGLES = 20_000_000
"""More would not fit into the memory of the machine that the limits of a picture are made for."""

Arrays = tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray | None]


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one material in a file: vertices (v, 3), triangles (f, 3), normals (v, 3) and texture coordinates
    (v, 2) or None, and the material as trimesh has it.
    """

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None
    uvs: np.ndarray | None
    material: Any


def read_mesh(path: str, place: str) -> Arrays:
    """Vertices (v, 3), triangles (f, 3), normals (v, 3) and texture coordinates (v, 2), those of the file or None.

    All parts of a file are joined, its transforms applied. Raises `SceneError` that begins with `place`.
    """
    parts = read_parts(path, place)
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return (
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, first[:-1], strict=True)]),
        _all_of([part.normals for part in parts]),
        _all_of([part.uvs for part in parts]),
    )


def read_parts(path: str, place: str, **how: Any) -> list[Part]:
    """The parts of a mesh file, each checked; `how`: options of trimesh's reader.

    Raises `SceneError` that begins with `place`.
    """
    file = Path(path)
    check_file(file, MESH_FILES, f"{place}: file = {path!r}")
    _check_promise(file, place)
    import trimesh

    try:
        found = trimesh.load(file, process=False, maintain_order=True, **how)
        meshes = found.dump() if isinstance(found, trimesh.Scene) else [found]
        parts = [_part(mesh) for mesh in meshes if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
    except Exception as error:  # trimesh raises whatever its parsers come across
        raise SceneError(
            f"{place}: file = {path!r} cannot be read as {file.suffix[1:].upper()}: {type(error).__name__}: {error}"
        ) from None
    if not parts:
        raise SceneError(f"{place}: file = {path!r} holds no triangle; allowed is a mesh of one or more")
    if not all(np.isfinite(part.vertices).all() for part in parts):
        raise SceneError(f"{place}: file = {path!r}: a vertex is not finite; export the mesh again")
    return parts


def _part(mesh) -> Part:
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    normals = mesh._cache.cache.get("vertex_normals")
    uvs = getattr(mesh.visual, "uv", None)
    normals = None if normals is None or len(normals) != len(vertices) else np.asarray(normals, np.float64)
    uvs = None if uvs is None or len(uvs) != len(vertices) else np.asarray(uvs, np.float64)[:, :2]
    return Part(vertices, faces, normals, uvs, getattr(mesh.visual, "material", None))


def _all_of(parts) -> np.ndarray | None:
    """Of all parts, None where one has none."""
    return None if any(part is None for part in parts) else np.concatenate(parts)


def _check_promise(file: Path, place: str) -> None:
    """Refuse a file whose head promises more than the file can hold, before anything is made room for."""
    size = file.stat().st_size
    if not size:
        raise SceneError(f"{place}: file = {str(file)!r} is empty")
    with file.open("rb") as opened:
        head = opened.read(4096)
    promised = 0
    if file.suffix.lower() == ".stl" and not head.lstrip().startswith(b"solid") and len(head) >= 84:
        promised = struct.unpack("<I", head[80:84])[0]
        if size < 84 + 50 * promised:
            raise SceneError(
                f"{place}: file = {str(file)!r} promises {promised:,} triangles and holds {max(size - 84, 0) // 50:,}; "
                "it was cut short, or is no STL"
            )
    elif file.suffix.lower() == ".ply":
        counts = [line.split() for line in head.split(b"end_header")[0].splitlines() if line.startswith(b"element")]
        sizes = [int(words[2]) for words in counts if len(words) == 3 and words[2].isdigit()]
        promised = max(sizes, default=0)
        if promised > size:
            raise SceneError(
                f"{place}: file = {str(file)!r} promises {promised:,} elements in {size:,} bytes; it was cut short, or "
                "is no PLY"
            )
    if promised > MOST_TRIANGLES:
        raise SceneError(
            f"{place}: file = {str(file)!r} holds {promised:,} elements; allowed is {MOST_TRIANGLES:,}. Simplify it"
        )
