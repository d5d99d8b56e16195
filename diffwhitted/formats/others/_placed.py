"""Shapes of other programs under an affine transform: as the kind that says it exactly, else as triangles.

A transform is a matrix (4, 4), float64; points are columns.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..._errors import SceneError
from ...scene import AbstractObject, Box, Cone, Cylinder, Disc, Mesh, Plane, Polygon, Quadric, Sphere, Torus
from .._facets import disc as disc_facets
from .._facets import frustum as frustum_facets
from .._facets import torus as torus_facets

EVEN = 1e-6
"""Part by which the axes of an even transform may differ."""
UNIT_BALL = (1, 1, 1, 0, 0, 0, 0, 0, 0, -1)

Maker = Callable[[str, str], AbstractObject]
"""An object, given its name and that of its material."""


def linear(matrix: np.ndarray) -> np.ndarray:
    return matrix[:3, :3]


def shift(matrix: np.ndarray) -> np.ndarray:
    return matrix[:3, 3]


def at(matrix: np.ndarray, points) -> np.ndarray:
    """Points (..., 3) where the transform takes them."""
    return np.asarray(points, np.float64) @ linear(matrix).T + shift(matrix)


def even_growth(matrix: np.ndarray) -> float | None:
    """By what lengths grow, where that is the same in all directions; else None."""
    square = linear(matrix).T @ linear(matrix)
    growth = np.trace(square) / 3
    return float(np.sqrt(growth)) if abs(square - growth * np.eye(3)).max() <= EVEN * growth else None


def is_mirrored(matrix: np.ndarray) -> bool:
    return bool(np.linalg.det(linear(matrix)) < 0)


def check(matrix: np.ndarray, place: str) -> None:
    """Raise `SceneError` where a transform is not finite or makes all things flat."""
    size = abs(linear(matrix)).max()
    if not np.isfinite(matrix).all() or not size > 0 or abs(np.linalg.det(linear(matrix) / size)) < 1e-12:
        raise SceneError(f"{place}: a transform makes it flat or endless; allowed are finite factors other than 0")


def sphere(matrix: np.ndarray, centre, radius: float) -> Maker:
    """A ball; an ellipsoid where the transform is not even."""
    growth = even_growth(matrix)
    if growth is not None:
        return lambda name, material: Sphere(name, at(matrix, centre), growth * radius, material)
    place = matrix @ translated(centre) @ np.diag([radius, radius, radius, 1])
    return lambda name, material: Quadric(name, UNIT_BALL, material).placed(matrix=_unmirrored(place))


def box(matrix: np.ndarray, low, high) -> Maker:
    """Between two corners."""
    low, high = np.minimum(low, high), np.maximum(low, high)
    turned = linear(matrix)
    if (np.count_nonzero(abs(turned) > EVEN * abs(turned).max(), axis=0) == 1).all():
        ends = at(matrix, np.stack([low, high]))
        return lambda name, material: Box(name, ends.min(axis=0), ends.max(axis=0), material)
    place = matrix @ translated((low + high) / 2) @ np.diag([*(high - low) / 2, 1])
    return lambda name, material: Box(name, [-1] * 3, [1] * 3, material).placed(matrix=_unmirrored(place))


def plane(matrix: np.ndarray, normal, offset: float) -> Maker:
    """normal.x = offset, of a normal of unit length; the inside stays the inside."""
    turned = np.linalg.solve(linear(matrix).T, np.asarray(normal, np.float64))
    size = np.linalg.norm(turned)
    away = (offset + turned @ shift(matrix)) / size
    return lambda name, material: Plane(name, turned / size, away, material)


def polygon(matrix: np.ndarray, corners) -> Maker:
    corners = at(matrix, corners)
    return lambda name, material: Polygon(name, corners, material)


def disc(matrix: np.ndarray, centre, normal, radius: float) -> Maker:
    return _by_growth(
        matrix,
        lambda growth: (
            lambda name, material: Disc(
                name, at(matrix, centre), linear(matrix) @ np.asarray(normal, float), growth * radius, material
            )
        ),
        lambda: disc_facets(Disc("disc", centre, normal, radius, ""), *_NOWHERE),
    )


def frustum(matrix: np.ndarray, base, top, low: float, high: float, capped: bool) -> Maker:
    """A cylinder where both radii are one, else a cone. A transform may stretch it along its axis."""
    base, top = (np.asarray(end, np.float64) for end in (base, top))
    growth = _round_growth(matrix, top - base)
    if growth is not None:
        first, second = at(matrix, base), at(matrix, top)
        return lambda name, material: _frustum(name, first, second, low * growth, high * growth, material, capped)
    return _facetted(matrix, lambda: frustum_facets(_frustum("frustum", base, top, low, high, "", capped), *_NOWHERE))


def torus(matrix: np.ndarray, centre, axis, major: float, minor: float) -> Maker:
    return _by_growth(
        matrix,
        lambda growth: (
            lambda name, material: Torus(
                name,
                at(matrix, centre),
                linear(matrix) @ np.asarray(axis, float),
                growth * major,
                growth * minor,
                material,
            )
        ),
        lambda: torus_facets(Torus("torus", centre, axis, major, minor, ""), *_NOWHERE),
    )


def quadric(matrix: np.ndarray, coefficients, low=None, high=None) -> Maker:
    """Of a mirrored transform the coefficients are those of the mirrored shape."""
    coefficients = np.asarray(coefficients, np.float64)
    if is_mirrored(matrix):
        # Turn z round twice: in the shape, and before the transform.
        matrix, coefficients = matrix @ np.diag([1, 1, -1, 1]), coefficients * (1, 1, 1, 1, -1, -1, 1, 1, -1, 1)
        if low is not None and high is not None:
            low, high = (*low[:2], -high[2]), (*high[:2], -low[2])
    if np.array_equal(matrix, np.eye(4)):
        return lambda name, material: Quadric(name, coefficients, material, low, high)
    return lambda name, material: Quadric(name, coefficients, material, low, high).placed(matrix=matrix)


def mesh(matrix: np.ndarray, vertices, faces, normals=None, uvs=None) -> Maker:
    """Triangles; smooth where they have normals. Mirrored ones keep their outer sides."""
    return _triangles(matrix, vertices, normals, faces, uvs)


_NOWHERE: tuple[np.ndarray, float] = (np.zeros(3), 1.0)


def _frustum(name: str, base, top, low: float, high: float, material: str, capped: bool) -> Cylinder | Cone:
    if low == high:
        return Cylinder(name, base, top, low, material, capped=capped)
    return Cone(name, base, top, low, high, material, capped=capped)


def _by_growth(matrix: np.ndarray, exact: Callable[[float], Maker], facets: Callable[[], Any]) -> Maker:
    growth = even_growth(matrix)
    return exact(growth) if growth is not None else _facetted(matrix, facets)


def _facetted(matrix: np.ndarray, facets: Callable[[], Any]) -> Maker:
    return lambda name, material: _triangles(matrix, *facets())(name, material)


def _round_growth(matrix: np.ndarray, axis: np.ndarray) -> float | None:
    """By what circles about the axis grow, where they stay circles across it; else None."""
    axis = axis / np.linalg.norm(axis)
    across = np.cross(np.eye(3)[abs(axis).argmin()], axis)
    across /= np.linalg.norm(across)
    first, second, along = (linear(matrix) @ np.stack([across, np.cross(axis, across), axis], axis=1)).T
    sizes = np.linalg.norm([first, second, along], axis=1)
    square = np.asarray([first @ second, first @ along, second @ along])
    if abs(square).max() > EVEN * sizes.max() ** 2 or abs(sizes[0] - sizes[1]) > EVEN * sizes[0]:
        return None
    return float(sizes[0])


def _triangles(matrix: np.ndarray, points, normals, faces, uvs=None) -> Maker:
    points, faces = at(matrix, points), np.asarray(faces)
    faces = faces[:, ::-1] if is_mirrored(matrix) else faces
    if normals is not None:
        normals = np.asarray(normals, np.float64) @ np.linalg.inv(linear(matrix))
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    shading = "flat" if normals is None else "phong"
    return lambda name, material: Mesh(name, points, faces, material, normals=normals, uvs=uvs, shading=shading)


def translated(by) -> np.ndarray:
    found = np.eye(4)
    found[:3, 3] = by
    return found


def turned(axis: int, angle: float) -> np.ndarray:
    """About x, y or z (0, 1, 2) by radians, (4, 4), right-handed on column vectors."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    found = np.eye(4)
    found[first, first] = found[second, second] = np.cos(angle)
    found[first, second], found[second, first] = -np.sin(angle), np.sin(angle)
    return found


def _unmirrored(matrix: np.ndarray) -> np.ndarray:
    """For what is its own mirror image along each axis."""
    return matrix @ np.diag([1, 1, -1, 1]) if is_mirrored(matrix) else matrix
