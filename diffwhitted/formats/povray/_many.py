"""Meshes, patches and sets of spheres in POV-Ray's words."""

from collections.abc import Callable

import numpy as np

from ...scene import Mesh, Patch, SphereSet
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


def patch(thing: Patch) -> str:
    """One shape for each sixteen points, divided until it is flat to a thousandth of them."""
    control = plain(thing.control_points)
    flat = f"type 1 flatness {text(1e-3 * float(np.ptp(control, axis=0).max()))} u_steps 5 v_steps 5"
    each = (f"bicubic_patch {{ {flat} {', '.join(map(place, points))} }}" for points in control.reshape(-1, 16, 3))
    return f"union {{ {' '.join(each)}"


def _vectors(key: str, vectors: np.ndarray) -> str:
    return f"{key} {{ {len(vectors)}, {', '.join(map(place, vectors))} }}"


MANY: dict[type, Callable[..., str]] = {Mesh: mesh, Patch: patch, SphereSet: sphere_set}
