"""Shapes as triangles, for programs that know nothing else or no such shape."""

from collections.abc import Callable

import numpy as np

from ..scene import Checker, Plane, Polygon, Sphere
from ._numbers import listed, plain

RINGS, SECTORS = 32, 64
"""Of a sphere: its largest distance from the ball is 0.5 % of the radius."""
WIDE = 100.0
"""Half the side of the square in place of a plane, in sizes of the scene."""

Mesh = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Points (n, 3), unit normals (n, 3), triangles (m, 3), counter-clockwise seen from outside."""


def ball() -> Mesh:
    """A unit sphere about the origin, the axis along y."""
    polar, azimuth = np.meshgrid(
        np.linspace(0, np.pi, RINGS + 1), np.linspace(0, 2 * np.pi, SECTORS + 1), indexing="ij"
    )
    points = np.stack([np.sin(polar) * np.sin(azimuth), np.cos(polar), np.sin(polar) * np.cos(azimuth)], axis=-1)
    first = (np.arange(RINGS)[:, None] * (SECTORS + 1) + np.arange(SECTORS)).ravel()
    below = first + SECTORS + 1
    upper = np.stack([first, below, first + 1], axis=-1)[SECTORS:]
    lower = np.stack([first + 1, below, below + 1], axis=-1)[:-SECTORS]
    points = points.reshape(-1, 3)
    return points, points, np.concatenate([upper, lower])


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


MESHES: dict[type, Callable[..., Mesh]] = {Sphere: sphere, Polygon: polygon, Plane: plane}
"""A kind of shape is a function here: of the thing, and of the middle and the size of its scene."""


def frame(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors square to a unit normal and to each other; with it they are right-handed."""
    aside = np.eye(3)[np.argmin(abs(normal))]
    across = np.cross(aside, normal)
    across /= np.linalg.norm(across)
    return across, np.cross(normal, across)


def triangulated(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Triangles (n - 2, 3) of a plane polygon without crossings: ears are cut off one by one."""
    flat = points @ np.stack(frame(normal)).T
    left, triangles = list(range(len(points))), []
    while len(left) > 3:
        place = next((k for k in range(len(left)) if _is_ear(flat, left, k)), 0)
        triangles.append([left[place - 1], left[place], left[(place + 1) % len(left)]])
        del left[place]
    return np.asarray([*triangles, left])


def _is_ear(flat: np.ndarray, left: list[int], place: int) -> bool:
    corners = [left[place - 1], left[place], left[(place + 1) % len(left)]]
    a, b, c = flat[corners]
    others = flat[[k for k in left if k not in corners]]
    # A corner that turns outwards, and nothing of the rest in its triangle.
    sides = [_turn(p, q, others) for p, q in ((a, b), (b, c), (c, a))]
    return _turn(a, b, c) > 0 and not np.all([side >= 0 for side in sides], axis=0).any()


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray):
    """Twice the area of the triangle, positive counter-clockwise."""
    return (b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0])


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
