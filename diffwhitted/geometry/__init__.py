"""Where a ray meets a surface. No colour, no light: rays in, hits out."""

from ._edges import hidden_parts, near_outlines, nearest_part, outline_of, turning_at
from ._footprint import Edge, Footprint, covered, edge_of, narrowed, spread, uncovered
from ._hit import Hit
from ._plane import Planes
from ._polygon import Polygons
from ._ray import NOTHING, Departure, Ray
from ._shapes import Shapes, blocked, containing, crossing_count, facing, nearest, surface_at
from ._sphere import Spheres

__all__ = [
    "NOTHING", "Departure", "Edge", "Footprint", "Hit", "Planes", "Polygons", "Ray", "Shapes", "Spheres",
    "blocked", "containing", "covered", "crossing_count", "edge_of", "facing", "hidden_parts",
    "narrowed", "near_outlines", "nearest", "nearest_part",
    "outline_of", "spread", "surface_at", "turning_at", "uncovered",
]
