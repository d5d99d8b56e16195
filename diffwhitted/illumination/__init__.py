"""What a point sends back of the light that arrives there."""

from ._phong import diffuse, halfway_apart, lit, lobe, lobe_mean, reflected_apart
from ._visibility import before, sees_light, surfaces_crossed, tint

__all__ = [
    "before",
    "diffuse",
    "halfway_apart",
    "lit",
    "lobe",
    "lobe_mean",
    "reflected_apart",
    "sees_light",
    "surfaces_crossed",
    "tint",
]
