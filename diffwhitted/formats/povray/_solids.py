"""Boxes, discs, cylinders, cones, tori, quadrics and polyhedra in POV-Ray's words, a function a kind."""

from collections.abc import Callable

import numpy as np

from ...scene import Box, Cone, Cylinder, Disc, Polyhedron, Quadric, Torus
from .._meshes import MESHES
from .._numbers import listed, plain, text
from .._outlines import frame
from ._words import place

FLIP = np.asarray([1.0, 1.0, -1.0])
"""z is turned round."""
INSIDE = "inside_vector <0.267,0.535,0.802>"
"""Tells POV-Ray that triangles close a body."""


def placed(columns: np.ndarray, origin: np.ndarray) -> str:
    """Where the axes and the origin of POV-Ray's own shape go, by what ours would be."""
    return f"matrix <{', '.join(listed(row * FLIP, ',') for row in (*columns, origin))}>"


def box(thing: Box) -> str:
    if thing.sides is None:
        ends = np.stack([plain(thing.minimum), plain(thing.maximum)]) * FLIP
        return f"box {{ <{listed(ends.min(axis=0), ',')}>, <{listed(ends.max(axis=0), ',')}>"
    return f"box {{ 0, 1 {placed(plain(thing.sides), plain(thing.minimum))}"


def disc(thing: Disc) -> str:
    return f"disc {{ {place(plain(thing.centre))}, {place(thing.flat()[0])}, {text(float(plain(thing.radius)))}"


def cylinder(thing: Cylinder) -> str:
    ends = f"{place(plain(thing.base))}, {place(plain(thing.top))}"
    return f"cylinder {{ {ends}, {text(float(plain(thing.radius)))}{_open(thing)}"


def cone(thing: Cone) -> str:
    base, top = (text(float(plain(radius))) for radius in (thing.base_radius, thing.top_radius))
    return f"cone {{ {place(plain(thing.base))}, {base}, {place(plain(thing.top))}, {top}{_open(thing)}"


def _open(thing: Cylinder | Cone) -> str:
    return "" if thing.capped else " open"


def torus(thing: Torus) -> str:
    """POV-Ray's own lies about y."""
    axis = plain(thing.axis) / np.linalg.norm(plain(thing.axis))
    across, along = frame(axis)
    radii = f"{text(float(plain(thing.major_radius)))}, {text(float(plain(thing.minor_radius)))}"
    return f"torus {{ {radii} sturm {placed(np.stack([across, axis, along]), plain(thing.centre))}"


def quadric(thing: Quadric) -> str:
    xx, yy, zz, xy, xz, yz, x, y, z, constant = plain(thing.coefficients)
    rows = (xx, yy, zz), (xy, -xz, -yz), (x, y, -z)
    found = f"quadric {{ {', '.join(f'<{listed(row, chr(44))}>' for row in rows)}, {text(constant)}"
    if thing.minimum is not None:
        ends = np.stack([plain(thing.minimum), plain(thing.maximum)]) * FLIP
        found += f" clipped_by {{ box {{ <{listed(ends.min(axis=0), ',')}>, <{listed(ends.max(axis=0), ',')}> }} }}"
    if thing.frame is None:
        return found
    frame_ = plain(thing.frame)
    # The axes of POV-Ray's own are ours with z turned round.
    return f"{found} {placed(frame_[:, :3].T * FLIP[:, None], frame_[:, 3])}"


def polyhedron(thing: Polyhedron) -> str:
    points, _, triangles = MESHES[Polyhedron](thing, np.zeros(3), 1.0)
    corners = (", ".join(place(points[k]) for k in triangle) for triangle in triangles)
    return f"mesh {{ {' '.join(f'triangle {{ {three} }}' for three in corners)} {INSIDE}"


SOLIDS: dict[type, Callable[..., str]] = {
    Box: box,
    Disc: disc,
    Cylinder: cylinder,
    Cone: cone,
    Torus: torus,
    Quadric: quadric,
    Polyhedron: polyhedron,
}
