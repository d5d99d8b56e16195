"""Meshes and sets of spheres in POV-Ray's words."""

from collections.abc import Callable

import numpy as np

from ...scene import Mesh, SphereSet
from .._many import mesh as triangles_of
from .._numbers import plain, text
from ._solids import INSIDE
from ._words import place


def mesh(thing: Mesh) -> str:
    points, normals, faces = plain(thing.vertices), None, np.asarray(thing.faces)
    if thing.shading != "flat":
        points, normals, faces = triangles_of(thing, np.zeros(3), 1.0)
    parts = [_vectors("vertex_vectors", points)]
    parts += [] if normals is None else [_vectors("normal_vectors", normals)]
    parts.append(f"face_indices {{ {len(faces)}, {', '.join(f'<{a},{b},{c}>' for a, b, c in faces.tolist())} }}")
    parts += [INSIDE] if thing.closed else []
    return f"mesh2 {{ {' '.join(parts)}"


def sphere_set(thing: SphereSet) -> str:
    radii = plain(np.asarray(thing.each_radius()))
    balls = (f"sphere {{ {place(c)}, {text(float(r))} }}" for c, r in zip(plain(thing.centres), radii, strict=True))
    return f"union {{ {' '.join(balls)}"


def _vectors(key: str, vectors: np.ndarray) -> str:
    return f"{key} {{ {len(vectors)}, {', '.join(map(place, vectors))} }}"


MANY: dict[type, Callable[..., str]] = {Mesh: mesh, SphereSet: sphere_set}
