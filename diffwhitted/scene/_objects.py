"""What is where: named shapes, each of one material.

A new shape is a record here, a family in `geometry/`, and a line in `_tables.py` that stacks it.
"""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ._checks import is_traced, number_array, require


class Sphere(eqx.Module):
    """A sphere: centre and radius in metres."""

    centre: Float[Array, "3"]
    radius: Float[Array, ""]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, centre, radius, material: str, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        self.centre = number_array(centre, place, "centre", ((3,),))
        self.radius = number_array(radius, place, "radius", ((),))
        require(lambda r: r > 0, place, "radius", self.radius, "> 0")


class Plane(eqx.Module):
    """The plane normal.x = offset; its inside is the half space that the normal points away from.

    The normal need not have unit length: the equation is taken as it stands.
    """

    normal: Float[Array, "3"]
    offset: Float[Array, ""]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, normal, offset, material: str, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        self.normal = number_array(normal, place, "normal", ((3,),))
        self.offset = number_array(offset, place, "offset", ((),))
        require(lambda n: (n != 0).any(), place, "normal", self.normal, "any vector but zero")


class Polygon(eqx.Module):
    """A plane polygon (a triangle among them) by its vertices, counter-clockwise seen from outside.

    Raises `SceneError` for fewer than three vertices, for no area, and for vertices off the common plane.
    """

    vertices: Float[Array, "v 3"]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, vertices, material: str, place: str | None = None):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        count = len(vertices)
        if count < 3:
            raise SceneError(f"{place}: vertices has {count} points; allowed is three or more")
        self.vertices = number_array(vertices, place, "vertices", ((count, 3),))
        if not is_traced(self.vertices):
            _check_flat(np.asarray(self.vertices, np.float64), place)


def _check_flat(vertices, place):
    spokes = vertices - vertices[0]
    size = np.abs(spokes).max()
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    if np.linalg.norm(area) <= 1e-9 * size * size or size == 0:
        raise SceneError(
            f"{place}: vertices span no area (all on one line, or the same point); move one of them off the line"
        )
    away = np.abs(spokes @ (area / np.linalg.norm(area))).max()
    if away > 1e-3 * size:
        raise SceneError(f"{place}: vertices are not in one plane (off by {away:.3g} m); split it into triangles")


Object = Sphere | Plane | Polygon
