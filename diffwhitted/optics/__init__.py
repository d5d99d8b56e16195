"""How a ray bends and splits at a surface."""

from ._bend import Turn, along_surface, eta_at, mirrored, refracted, refraction_radicand, sine_squared, turn_at

__all__ = ["Turn", "along_surface", "eta_at", "mirrored", "refracted", "refraction_radicand", "sine_squared", "turn_at"]
