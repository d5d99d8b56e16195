"""How a ray bends and splits at a surface."""

from ._bend import Turn, along_surface, eta_at, mirrored, refracted, refraction_radicand, sine_squared, turn_at
from ._fresnel import fresnel_exact, fresnel_schlick, grazing, normal_reflectance, rising

__all__ = [
    "Turn", "along_surface", "eta_at", "fresnel_exact", "fresnel_schlick", "grazing", "mirrored", "normal_reflectance",
    "refracted", "refraction_radicand", "rising", "sine_squared", "turn_at",
]  # fmt: skip
