"""Where a ray meets a surface. No colour, no light: rays in, hits out."""

from ._hit import Hit
from ._plane import Planes
from ._polygon import Polygons
from ._ray import NOTHING, Departure, Ray
from ._shapes import Shapes, blocked, containing, crossing_count, facing, nearest, surface_at
from ._sphere import Spheres

__all__ = [
    "NOTHING", "Departure", "Hit", "Planes", "Polygons", "Ray", "Shapes", "Spheres",
    "blocked", "containing", "crossing_count", "facing", "nearest", "surface_at",
]
