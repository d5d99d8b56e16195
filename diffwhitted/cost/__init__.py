"""What a picture costs: its effects, its rays, and the parts of its work."""

from ._effects import EffectCost, PictureCost
from ._explain import ExplainedEffect, Explanation, explain
from ._rays import RayCounts, RayMaps, ray_maps
from ._search import SearchCounts
from ._work import Work

__all__ = [
    "EffectCost",
    "ExplainedEffect",
    "Explanation",
    "PictureCost",
    "RayCounts",
    "RayMaps",
    "SearchCounts",
    "Work",
    "explain",
    "ray_maps",
]
