"""The one list of shapes. A new shape is a file in this folder and its name here."""

from ..records import Registry
from ._box import Box
from ._cone import Cone
from ._cylinder import Cylinder
from ._disc import Disc
from ._mesh import Mesh
from ._object import AbstractObject
from ._patch import Patch
from ._plane import Plane
from ._polygon import Polygon
from ._polyhedron import Polyhedron
from ._quadric import Quadric
from ._sphere import Sphere
from ._sphere_set import SphereSet
from ._torus import Torus

OBJECTS: Registry[AbstractObject] = Registry(
    "object", AbstractObject, Sphere, Plane, Polygon, Box, Disc, Cylinder, Cone, Quadric, Torus, Polyhedron, SphereSet,
    Mesh, Patch,
)  # fmt: skip
