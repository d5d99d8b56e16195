"""The one list of shapes. A new shape is a file in this folder and its name here."""

from ..records import Registry
from ._mesh import Mesh
from ._object import AbstractObject
from ._plane import Plane
from ._polygon import Polygon
from ._sphere import Sphere
from ._sphere_set import SphereSet

OBJECTS: Registry[AbstractObject] = Registry("object", AbstractObject, Sphere, Plane, Polygon, Mesh, SphereSet)
