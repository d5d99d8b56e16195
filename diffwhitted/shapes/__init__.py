"""What can be there: a shape a file, with the record that a scene holds and the family that rays meet."""

from ._kinds import OBJECTS
from ._mesh import Mesh
from ._object import AbstractObject
from ._plane import Plane, Planes
from ._polygon import Polygon, Polygons
from ._sphere import Sphere, Spheres
from ._sphere_set import SphereSet
from ._triangles import Triangles

__all__ = [
    "OBJECTS", "AbstractObject", "Mesh", "Plane", "Planes", "Polygon", "Polygons", "Sphere", "SphereSet", "Spheres",
    "Triangles",
]  # fmt: skip
