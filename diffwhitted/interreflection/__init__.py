"""Light between diffuse surfaces: patches, their form factors, and the radiosity of patches (Hearn and Baker 14-7)."""

from ._faces import KINDS, Face, faces_of
from ._factors import Factors, form_factors
from ._lambert import towards_each, towards_polygons
from ._patches import MOST_PATCHES, SAMPLES, Chart, Patches, Places, patches_of
from ._solvers import SOLVERS, Solver, after_shots, solve

__all__ = [
    "Chart", "Face", "Factors", "KINDS", "MOST_PATCHES", "Patches", "Places", "SAMPLES", "SOLVERS", "Solver",
    "after_shots", "faces_of", "form_factors", "patches_of", "solve", "towards_each", "towards_polygons",
]  # fmt: skip
