"""Faces of meshes: checks, triangles in place of longer faces, normals of vertices, and whether they close a volume."""

import warnings
from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from .._errors import SceneError, SceneNote
from ..numerics._safe import normalise
from ..numerics._vector import vec3
from ..records import is_traced
from ._ears import cut_into_triangles

NO_AREA = 1e-12
"""A triangle with less than this share of the square of its longest side as area is none."""


def checked_faces(faces, count: int, place: str) -> np.ndarray | list[list[int]]:
    """The faces as an array (f, k), or as lists where they differ in length. Raises `SceneError` for what is no list of
    whole numbers, for a face of fewer than three, and for a number that is no vertex.
    """
    if not isinstance(faces, np.ndarray):
        faces = [list(face) for face in faces]
        lengths = set(map(len, faces))
        faces = np.asarray(faces) if len(lengths) == 1 else faces
    flat = faces.ravel() if isinstance(faces, np.ndarray) else np.asarray([k for face in faces for k in face])
    if not len(faces):
        raise SceneError(f"{place}: faces is empty; allowed is one face or more")
    if flat.dtype.kind not in "iu":
        raise SceneError(f"{place}: faces holds {flat.dtype.name}; allowed is whole numbers, those of vertices from 0")
    short = next((k for k, face in enumerate(faces) if len(face) < 3), None)
    if short is not None:
        raise SceneError(f"{place}: faces[{short}] has {len(faces[short])} vertices; allowed is three or more")
    wrong = next((k for k, face in enumerate(faces) if min(face) < 0 or max(face) >= count), None) if (
        flat.min() < 0 or flat.max() >= count
    ) else None  # fmt: skip
    if wrong is not None:
        raise SceneError(
            f"{place}: faces[{wrong}] = {list(map(int, faces[wrong]))}, and there are {count} vertices; "
            f"allowed is 0 to {count - 1}"
        )
    return faces


def as_triangles(
    faces: np.ndarray | list[list[int]], vertices: np.ndarray | None, place: str
) -> Int[np.ndarray, "f 3"]:
    """The triangles that faces are made of; those without an area are left out, with a note.

    `vertices`: None where they are not known; then a longer face is cut into a fan.
    """
    if isinstance(faces, np.ndarray) and faces.shape[1] == 3:
        triangles = faces.astype(np.int32)
    else:
        triangles = np.concatenate([_cut(face, vertices) for face in faces]).astype(np.int32)
    if vertices is None:
        return triangles
    corners = vertices[triangles]
    sides = corners - np.roll(corners, 1, axis=1)
    longest = (sides**2).sum(axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    there = area > NO_AREA * longest
    if not there.any():
        raise SceneError(f"{place}: none of its {len(triangles)} triangles has an area; look at its vertices")
    if not there.all():
        lost = len(there) - int(there.sum())
        said = f"{place}: {lost} of {len(there)} triangles have no area and are left out"
        warnings.warn(said, SceneNote, stacklevel=4)
    return triangles[there]


def of_unit_length(vectors: Any) -> Any:
    """Vectors (*n, 3) over their lengths, zero for zero: on the host where they are known, else differentiable."""
    if is_traced(vectors):
        return normalise(vec3(vectors)).stacked()
    vectors = np.asarray(vectors)
    precise = vectors.astype(np.float64)
    size = np.linalg.norm(precise, axis=-1, keepdims=True)
    return (precise / np.where(size > 0, size, 1)).astype(vectors.dtype)


def flat_normals(vertices: Any, faces: Any) -> Any:
    """Outward unit normals (f, 3) of triangles, in the same way."""
    xp: Any = jnp if is_traced(vertices) else np
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return of_unit_length(xp.cross(b - a, c - a))


def mean_normals(vertices: Any, faces: Any) -> Any:
    """Unit normals (v, 3) of vertices, means of those of the faces around (Hearn and Baker 14-37); in the same way.

    A vertex of no face has the normal 0.
    """
    flat = flat_normals(vertices, faces)
    if is_traced(vertices):
        total = jnp.zeros(jnp.shape(vertices), flat.dtype).at[jnp.asarray(faces)].add(flat[:, None, :])
    else:
        count, around = len(vertices), np.asarray(faces).ravel()
        parts = [np.bincount(around, np.repeat(flat[:, k], 3), count) for k in range(3)]
        total = np.stack(parts, axis=-1).astype(vertices.dtype)
    return of_unit_length(total)


def closes(vertices: Any, faces: Any) -> bool:
    """Do the triangles close a volume: is each side that of two, which run along it in opposite ways?

    Vertices in one place are one, where they are known: files repeat them where normals or textures differ.
    """
    if vertices is not None and not closes(None, faces):
        faces = places_of(vertices)[faces]
    start, end = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    count = int(faces.max()) + 1
    along, back = np.sort(start * count + end), np.sort(end * count + start)
    return bool((along == back).all() and (np.diff(along) != 0).all())


def places_of(vertices: np.ndarray) -> Int[np.ndarray, "v"]:
    """The same number for vertices in one place, told by a hash of their bits: rows of floats take long to sort."""
    bits = np.ascontiguousarray(vertices.astype(np.float64) + 0.0).view(np.uint64)
    with np.errstate(over="ignore"):
        hashed = bits * np.asarray([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
        hashed = (hashed ^ (hashed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
        one = hashed[:, 0] ^ (hashed[:, 1] << np.uint64(1)) ^ (hashed[:, 2] << np.uint64(2))
    return np.unique(one, return_inverse=True)[1].ravel()


def signed_volume(vertices: Float[np.ndarray, "v 3"], faces: Int[np.ndarray, "f 3"]) -> float:
    """The volume within closed triangles, negative where they run clockwise seen from outside."""
    a, b, c = (vertices[faces[:, k]] - vertices[0] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def _cut(around: Sequence[int], vertices: np.ndarray | None) -> np.ndarray:
    face = np.asarray(around)
    if len(face) == 3:
        return face[None]
    if vertices is None:
        return np.stack([np.repeat(face[:1], len(face) - 2), face[1:-1], face[2:]], axis=1)
    # Look at it along its normal (Newell), so that ears are seen for what they are.
    points = vertices[face] - vertices[face[0]]
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    axis = int(abs(normal).argmax())
    across, along = (axis + 1) % 3, (axis + 2) % 3
    flat = points[:, [across, along]] if normal[axis] >= 0 else points[:, [along, across]]
    return face[cut_into_triangles(flat)]
