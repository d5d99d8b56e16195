"""Large arrays of a scene as files beside its own: spheres as .npz, meshes as .ply."""

import io
from pathlib import Path
from typing import cast

import numpy as np

from ..records import changed
from ..scene import AbstractObject, Mesh, Scene, SphereSet
from ._words import words_of

FEW = 64
"""An object of no more spheres, or triangles, stays in the scene file."""


def with_files(scene: Scene, path: Path) -> tuple[Scene, dict[Path, bytes]]:
    """The scene whose large sets of spheres and meshes name a file, and the bytes of these files.

    They lie beside `path`, the file of the scene, and are called after it and the object. The scene can be saved once
    they are written; it holds the same numbers. What names a file already is left as it is.
    """
    large = [thing.name for thing in scene.objects if _is_large(thing)]
    words = words_of(large, prefix=f"{path.stem}_", allowed=r"\w-", longest=120)
    files, objects = {}, []
    for thing in scene.objects:
        if thing.name in words:
            data, suffix = _file_of(thing)
            place = path.with_name(words[thing.name] + suffix)
            files[place] = data
            thing = changed(thing, file=str(place))
        objects.append(thing)
    return changed(scene, objects=tuple(objects)), files


def _is_large(thing: AbstractObject) -> bool:
    return isinstance(thing, (SphereSet, Mesh)) and thing.file is None and thing.surfaces > FEW


def _file_of(thing: AbstractObject) -> tuple[bytes, str]:
    """The bytes of its file, and the suffix of that."""
    return (_npz(thing), ".npz") if isinstance(thing, SphereSet) else (_ply(cast(Mesh, thing)), ".ply")


def _npz(spheres: SphereSet) -> bytes:
    """The arrays `centres` and `radii` in their own precision."""
    data = io.BytesIO()
    np.savez_compressed(data, centres=np.asarray(spheres.centres), radii=np.asarray(spheres.each_radius()))
    return data.getvalue()


def _ply(mesh: Mesh) -> bytes:
    """A binary PLY file with the triangles, and the normals and texture coordinates of the vertices if it has any."""
    columns = {"x y z": mesh.vertices, "nx ny nz": mesh.normals, "u v": mesh.uvs}
    stated = {keys: np.asarray(column) for keys, column in columns.items() if column is not None}
    table = np.concatenate(list(stated.values()), axis=1)
    real = "double" if table.dtype == np.float64 else "float"
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(table)}"]
    head += [f"property {real} {key}" for keys in stated for key in keys.split()]
    head += [f"element face {len(mesh.faces)}", "property list uchar int vertex_indices", "end_header", ""]
    faces = np.empty(len(mesh.faces), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"], faces["corners"] = 3, np.asarray(mesh.faces)
    return "\n".join(head).encode() + table.astype(table.dtype.newbyteorder("<")).tobytes() + faces.tobytes()
