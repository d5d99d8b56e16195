"""What can be there: a shape a file, with the record that a scene holds and the family that rays meet."""

from ._kinds import OBJECTS
from ._object import AbstractObject
from ._plane import Plane, Planes
from ._polygon import Polygon, Polygons
from ._sphere import Sphere, Spheres

__all__ = ["OBJECTS", "AbstractObject", "Plane", "Planes", "Polygon", "Polygons", "Sphere", "Spheres"]
