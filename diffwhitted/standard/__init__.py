"""Scenes that many have rendered, made by name."""

from ._parts import StandardScene, exponent_of, usual_strength, view_angle
from ._scenes import STANDARD, standard_scene

__all__ = ["STANDARD", "StandardScene", "exponent_of", "standard_scene", "usual_strength", "view_angle"]
