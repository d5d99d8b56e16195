"""What a smooth coat does to the light of lamps: the polished surface, and Fresnel's weight of a highlight.

Each gives the coefficients that stand in place of those of the point, for the points that are of its kind.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..numerics._safe import normalise
from ..numerics._vector import Vec3, dot, where
from ..optics import fresnel_exact, fresnel_schlick, grazing, normal_reflectance, refraction_radicand, rising
from ..scene import FRESNEL_MODELS, HIGHLIGHTS
from ._surface_point import SurfacePoint

Coefficients = dict[str, Vec3 | Float[Array, "n"]]
COUPLED = 21 / 20
"""Of what the coat lets through the matte base sends back as much under an even sky, 1 over twice 10/21."""
AROUND = "k_d_around"
"""What stands in place of k_d under light from all around, where a scene has polished surfaces."""


def polished(point: SurfacePoint) -> Coefficients:
    """The coupled model of Shirley, Hu, Smits and Lafortune 1997 as Parker et al. 3.1 have it: under ambient light

        R_m / (1 - R0) (1 - (1 - cos_i)**5),

    and under a lamp 21/20 of it, times `polished_towards`; R_m = k_d, R0 of the index. Under light from all around it
    is as under ambient light.
    """
    straight = normal_reflectance(point.eta)
    through = (1 - grazing(point.cosine)) / (1 - straight)
    factors = {"k_a": through, "k_d": COUPLED * through}
    found = _replaced(point, _is_polished(point), factors)
    if point.surroundings is not None and "k_d" in found:
        found[AROUND] = point.coefficients["k_d"] * jnp.where(_is_polished(point), through, 1)
    return found


def polished_towards(point: SurfacePoint, to_light: Vec3) -> Coefficients:
    """The part of the coupled model that hangs on the lamp: 1 - (1 - N.L)**5."""
    facing = jnp.clip(dot(point.shading_normal, to_light), 0, 1)
    return _replaced(point, _is_polished(point), {"k_d": 1 - grazing(facing)})


def fresnel_highlight(point: SurfacePoint, to_light: Vec3) -> Coefficients:
    """W(theta) of Hearn and Baker (14-5): k_h times F(N.L) of the reflected highlight, F(L.H) of the halfway one.

    Of a metal k_h is the reflectance at normal incidence, as k_s is: k_h + (1 - k_h) (1 - cos)**5.
    """
    halfway = dot(to_light, normalise(to_light - point.incoming))
    reflected = point.models["highlight"] == HIGHLIGHTS.index("reflected")
    cosine = jnp.clip(jnp.where(reflected, dot(point.shading_normal, to_light), halfway), 0, 1)
    # Ask each model for the reflectance of its points.
    model, k_h, eta = point.models["fresnel"], point.colour("k_h"), point.eta
    radicand = refraction_radicand(cosine, eta)
    coated = where(
        model == FRESNEL_MODELS.index("exact"),
        k_h * fresnel_exact(cosine, eta, radicand),
        k_h * fresnel_schlick(cosine, eta, radicand),
    )
    of_metal = Vec3(*(rising(channel, cosine) for channel in (k_h.x, k_h.y, k_h.z)))
    weighed = where(model == FRESNEL_MODELS.index("metal"), of_metal, coated)
    return {"k_h": where(point.models["fresnel_highlight"] > 0, weighed, k_h)}


def polished_most(most: dict[str, np.ndarray], refractive_index: float) -> dict[str, np.ndarray]:
    """The most that a polished material makes of its coefficients, (3,) each."""
    straight = ((refractive_index - 1) / (refractive_index + 1)) ** 2
    return most | {"k_a": most["k_a"] / (1 - straight), "k_d": COUPLED * most["k_d"] / (1 - straight)}


def _is_polished(point: SurfacePoint) -> Bool[Array, "n"]:
    return point.models["polished"] > 0


def _replaced(point: SurfacePoint, mine: Bool[Array, "n"], factors: dict[str, Float[Array, "n"]]) -> Coefficients:
    """The coefficients that there are times their factors, where the points are `mine`."""
    return {
        name: point.coefficients[name] * jnp.where(mine, factor, 1)
        for name, factor in factors.items()
        if name in point.coefficients
    }
