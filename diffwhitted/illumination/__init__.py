"""What a point sends back of the light that arrives there."""

from ._phong import diffuse, halfway_highlight, reflected_highlight
from ._visibility import sees_light, surfaces_crossed, tint

__all__ = ["diffuse", "halfway_highlight", "reflected_highlight", "sees_light", "surfaces_crossed", "tint"]
