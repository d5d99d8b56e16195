"""What can be there: a shape a file, with the record that a scene holds and the family that rays meet."""

from ._box import Box, Boxes
from ._cone import Cone
from ._cylinder import Cylinder
from ._disc import Disc, Discs
from ._ears import cut_into_triangles
from ._facets import mean_normals
from ._frusta import Frusta
from ._kinds import OBJECTS
from ._mesh import Mesh
from ._mesh_file import read_parts
from ._object import SHADING, AbstractObject
from ._patch import Patch
from ._patches import Patches, bernstein
from ._plane import Plane, Planes
from ._polygon import Polygon, Polygons
from ._polyhedron import Faces, Polyhedra, Polyhedron
from ._pose import POSE, VELOCITY, has_pose
from ._quadric import Quadric, Quadrics
from ._sphere import Sphere, Spheres
from ._sphere_set import SphereSet
from ._torus import Tori, Torus
from ._triangles import Triangles

__all__ = [
    "AbstractObject", "Box", "Boxes", "Cone", "Cylinder", "Disc", "Discs", "Faces", "Frusta", "Mesh", "OBJECTS",
    "POSE", "Patch", "Patches", "Plane", "Planes", "Polygon", "Polygons", "Polyhedra", "Polyhedron", "Quadric",
    "Quadrics", "SHADING", "Sphere", "SphereSet", "Spheres", "Tori", "Torus", "Triangles", "bernstein",
    "cut_into_triangles", "VELOCITY", "has_pose", "mean_normals", "read_parts",
]  # fmt: skip
