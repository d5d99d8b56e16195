"""What a point sends back of the light that arrives there."""

from ._phong import diffuse, halfway_highlight, lit, reflected_highlight
from ._visibility import before, sees_light, surfaces_crossed, tint

__all__ = ["before", "diffuse", "halfway_highlight", "lit", "reflected_highlight", "sees_light", "surfaces_crossed", "tint"]
