"""Shapes as triangles, for programs that know nothing else or no such shape."""

from collections.abc import Callable

import numpy as np

from ..scene import Box, Checker, Cone, Cylinder, Disc, Patch, Plane, Polygon, Polyhedron, Sphere, SphereSet, Torus
from ..scene import Mesh as TriangleMesh
from ._facets import Mesh, box, disc, frustum, polyhedron, torus
from ._many import mesh, patch, sphere_set
from ._numbers import listed, plain
from ._outlines import frame, triangulated
from ._rounds import ball

WIDE = 100.0
"""Half the side of the square in place of a plane, in sizes of the scene."""


def sphere(thing: Sphere, middle: np.ndarray, reach: float) -> Mesh:
    points, normals, triangles = ball()
    return plain(thing.centre) + points * float(plain(thing.radius)), normals, triangles


def polygon(thing: Polygon, middle: np.ndarray, reach: float) -> Mesh:
    points = plain(thing.vertices)
    normal = np.cross(points - points[0], np.roll(points, -1, axis=0) - points[0]).sum(axis=0)
    normal /= np.linalg.norm(normal)
    return points, np.tile(normal, (len(points), 1)), triangulated(points, normal)


def plane(thing: Plane, middle: np.ndarray, reach: float) -> Mesh:
    """A square of 2 `WIDE` sizes of the scene about the point nearest to its middle."""
    normal, offset = thing.half_space()
    across, along = frame(normal)
    foot = middle - (normal @ middle - offset) * normal
    signs = np.asarray([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * WIDE * reach
    points = foot + signs[:, :1] * across + signs[:, 1:] * along
    return points, np.tile(normal, (4, 1)), np.asarray([[0, 1, 2], [0, 2, 3]])


MESHES: dict[type, Callable[..., Mesh]] = {
    Sphere: sphere,
    Polygon: polygon,
    Plane: plane,
    Box: box,
    Disc: disc,
    Cylinder: frustum,
    Cone: frustum,
    Torus: torus,
    Polyhedron: polyhedron,
    SphereSet: sphere_set,
    TriangleMesh: mesh,
    Patch: patch,
}
"""A kind of shape is a function here: of the thing, and of the middle and the size of its scene."""


def checker_coordinates(checker: Checker, points: np.ndarray) -> np.ndarray | None:
    """u, v (n, 2) at points (n, 3) such that two cells are 1 and the first colour lies where u and v modulo 1 are both
    below a half, or both above; None where three axes are counted and the points do not share one of them.
    """
    scaled = (points - plain(checker.corner)) / (2 * float(plain(checker.size)))
    counted = ["xyz".index(axis) for axis in checker.axes]
    shift = 0.0
    if len(counted) == 3:
        still = [axis for axis in counted if np.ptp(points[:, axis]) == 0]
        if not still:
            return None
        counted.remove(still[0])
        shift = 0.5 * (np.floor(2 * scaled[0, still[0]]) % 2)
    u = scaled[:, counted[0]] + shift
    v = scaled[:, counted[1]] if len(counted) == 2 else np.full(len(points), 0.25)
    return np.stack([u, v], axis=-1)


def polygon_file(
    points: np.ndarray, normals: np.ndarray, triangles: np.ndarray, coordinates: np.ndarray | None
) -> bytes:
    """The triangles as a PLY file in text, with u, v (n, 2) if there are any."""
    columns = np.hstack([points, normals] + ([] if coordinates is None else [coordinates]))
    keys = ("x", "y", "z", "nx", "ny", "nz", "u", "v")[: columns.shape[1]]
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *(f"property float {key}" for key in keys)]
    head += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    faces = [f"3 {' '.join(map(str, corners))}" for corners in triangles.tolist()]
    return "\n".join([*head, *(listed(row) for row in columns), *faces, ""]).encode()
