"""What a point sends back of the light that arrives there."""

from ._borders import within_borders
from ._coated import AROUND, fresnel_highlight, polished, polished_most, polished_towards
from ._models import halfway_apart, reflected_apart
from ._penumbra import ball_beam, seen_of_ball
from ._phong import diffuse, lit, lobe, lobe_mean
from ._surface_point import Bent, SurfacePoint
from ._terms import Terms, light_footprint, light_terms
from ._visibility import before, count_bits, glass_crossed, sees_light, tint, whole_power
from ._wrinkles import lit_above_horizon

__all__ = [
    "AROUND", "Bent", "SurfacePoint", "Terms", "ball_beam", "before", "count_bits", "diffuse", "fresnel_highlight",
    "glass_crossed", "halfway_apart", "light_footprint", "light_terms", "lit", "lit_above_horizon", "lobe", "lobe_mean",
    "polished", "polished_most", "polished_towards", "reflected_apart", "seen_of_ball", "sees_light", "tint",
    "whole_power", "within_borders",
]  # fmt: skip
