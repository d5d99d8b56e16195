"""How a ray bends and splits at a surface."""

from ._bend import eta_at, mirrored, refracted, refracted_change, refraction_radicand

__all__ = ["eta_at", "mirrored", "refracted", "refracted_change", "refraction_radicand"]
