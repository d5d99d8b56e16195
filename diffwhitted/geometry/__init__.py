"""Where a ray meets a surface. No colour, no light: rays in, hits out."""

from ._edges import beside_small, curvature_at, hidden_parts, near_outlines, nearest_part, outline_of
from ._footprint import LEAST_COVERAGE, Edge, Footprint, covered, crosswise, edge_of, on_surface, part_of, uncovered
from ._hit import Hit
from ._ray import NOTHING, Departure, Ray
from ._search import Shapes, blocked, containing, crossing_count, facing, nearest, surface_at
from .shapes._plane import Planes
from .shapes._polygon import Polygons
from .shapes._sphere import Spheres

__all__ = [
    "LEAST_COVERAGE",
    "NOTHING",
    "Departure",
    "Edge",
    "Footprint",
    "Hit",
    "Planes",
    "Polygons",
    "Ray",
    "Shapes",
    "Spheres",
    "beside_small",
    "blocked",
    "containing",
    "covered",
    "crosswise",
    "crossing_count",
    "curvature_at",
    "edge_of",
    "facing",
    "hidden_parts",
    "near_outlines",
    "nearest",
    "nearest_part",
    "on_surface",
    "outline_of",
    "part_of",
    "surface_at",
    "uncovered",
]
