"""How a ray bends and splits at a surface."""

from ._bend import Turn, along_surface, eta_at, mirrored, refracted, refraction_radicand, sine_squared, turn_at
from ._catalogue import CATALOGUE_NAMES, catalogue_lines, cauchy_through
from ._fresnel import fresnel_exact, fresnel_schlick, grazing, normal_reflectance, rising
from ._spectrum import (
    LINE_C,
    LINE_D,
    LINE_F,
    abbe_number,
    band_weights,
    cauchy_index,
    sellmeier_index,
    spread,
    wavelengths,
)  # fmt: skip

__all__ = [
    "CATALOGUE_NAMES", "LINE_C", "LINE_D", "LINE_F", "Turn", "abbe_number", "along_surface", "band_weights",
    "catalogue_lines", "cauchy_index", "cauchy_through", "eta_at", "fresnel_exact", "fresnel_schlick", "grazing",
    "mirrored", "normal_reflectance", "refracted", "refraction_radicand", "rising", "sellmeier_index", "sine_squared",
    "spread", "turn_at", "wavelengths",
]  # fmt: skip
