"""Where a ray meets a surface. No colour, no light: rays in, hits out."""

from ._asking import Asked, free, search
from ._boxes import BoxTree, boxes_over, outwards
from ._compiled import compiled, prepare, searcher
from ._corners import Corners, corners_at
from ._edges import beside_small, curvature_at, hidden_parts, near_silhouettes, nearest_part, silhouette_of
from ._footprint import (
    LEAST_COVERAGE,
    Edge,
    Footprint,
    covered,
    crosswise,
    edge_of,
    on_surface,
    part_of,
    steps_on_surface,
    uncovered,
)  # fmt: skip
from ._hit import Hit
from ._outlines import divided, shaded_side
from ._ray import NOTHING, Departure, Ray, Sheets, sheet_at
from ._search import (
    GRAZING,
    Shapes,
    blocked,
    containing,
    crossing_counts,
    nearest,
    on_its_side,
    surface_at,
    towards,
    uv_at,
)  # fmt: skip
from ._sheets import hidden_by_layers, in_order, layers_crossed, neighbours
from ._sides import BITS, Sides, side_silhouette
from ._surface import AbstractSurfaces, Three
from ._tested import Tested, tested_for_blocked, tested_for_counts, tested_for_nearest

__all__ = [
    "BITS", "GRAZING", "LEAST_COVERAGE", "NOTHING", "AbstractSurfaces", "Asked", "BoxTree", "Corners", "Departure",
    "Edge", "Footprint", "Hit", "Ray", "Shapes", "Sheets", "Sides", "Tested", "Three", "beside_small", "blocked",
    "boxes_over", "compiled", "containing", "corners_at", "covered", "crossing_counts", "crosswise", "curvature_at",
    "divided", "edge_of", "free", "hidden_by_layers", "hidden_parts", "in_order", "layers_crossed",
    "near_silhouettes", "nearest", "nearest_part", "neighbours", "on_its_side", "on_surface", "outwards", "part_of",
    "prepare", "search", "searcher", "shaded_side", "sheet_at", "side_silhouette", "silhouette_of",
    "steps_on_surface", "surface_at", "tested_for_blocked", "tested_for_counts", "tested_for_nearest", "towards",
    "uncovered", "uv_at",
]  # fmt: skip
