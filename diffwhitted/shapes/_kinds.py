"""The one list of shapes. A new shape is a file in this folder and its name here."""

from ..records import Registry
from ._object import AbstractObject
from ._plane import Plane
from ._polygon import Polygon
from ._sphere import Sphere

OBJECTS: Registry[AbstractObject] = Registry("object", AbstractObject, Sphere, Plane, Polygon)
