"""What can be there: a shape a file, with the record that a scene holds and the family that rays meet."""

from ._box import Box, Boxes
from ._cone import Cone
from ._cylinder import Cylinder
from ._disc import Disc, Discs
from ._frusta import Frusta
from ._kinds import OBJECTS
from ._object import AbstractObject
from ._plane import Plane, Planes
from ._polygon import Polygon, Polygons
from ._polyhedron import Faces, Polyhedra, Polyhedron
from ._pose import POSE, has_pose
from ._quadric import Quadric, Quadrics
from ._sphere import Sphere, Spheres
from ._torus import Tori, Torus

__all__ = [
    "AbstractObject", "Box", "Boxes", "Cone", "Cylinder", "Disc", "Discs", "Faces", "Frusta", "OBJECTS", "POSE",
    "Plane", "Planes", "Polygon", "Polygons", "Polyhedra", "Polyhedron", "Quadric", "Quadrics", "Sphere", "Spheres",
    "Tori", "Torus",
    "has_pose",
]  # fmt: skip
