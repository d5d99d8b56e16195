"""How much of the light that meets a surface goes on along the mirror ray."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics._safe import safe_divide, safe_sqrt


def fresnel_exact(
    cos_i: Float[Array, "*n"], eta: Float[Array, "*n"], radicand: Float[Array, "*n"]
) -> Float[Array, "*n"]:
    """Fresnel's reflectance of a smooth dielectric for unpolarised light, (r_s**2 + r_p**2) / 2 with

        r_s = (eta cos_i - cos_r) / (eta cos_i + cos_r),   r_p = (eta cos_r - cos_i) / (eta cos_r + cos_i),

    `eta` the index on the ray's side over the one on the far side, `radicand` cos_r**2 (see `refraction_radicand`).
    Edges: 1 past the critical angle, with derivative 0; at that angle the derivative is 0, its one-sided limit
    infinite; at eta = 1 it is 0 with derivative 0.
    """
    cos_r = safe_sqrt(radicand)
    across = safe_divide(eta * cos_i - cos_r, eta * cos_i + cos_r)
    along = safe_divide(eta * cos_r - cos_i, eta * cos_r + cos_i)
    return jnp.where(radicand < 0, 1, 0.5 * (across * across + along * along))


def fresnel_schlick(
    cos_i: Float[Array, "*n"], eta: Float[Array, "*n"], radicand: Float[Array, "*n"]
) -> Float[Array, "*n"]:
    """Schlick's polynomial R0 + (1 - R0) (1 - cos)**5, R0 = ((1 - eta) / (1 + eta))**2, with the cosine on the less
    dense side (Schlick 1994; Parker et al. 3.1).

    Edges: those of `fresnel_exact`.
    """
    cosine = jnp.where(eta > 1, safe_sqrt(radicand), cos_i)
    return jnp.where(radicand < 0, 1, rising(normal_reflectance(eta), cosine))


def normal_reflectance(eta: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """R0 = ((1 - eta) / (1 + eta))**2, straight onto the surface; the same from both sides."""
    root = (1 - eta) / (1 + eta)
    return root * root


def rising(straight, cosine: Float[Array, "*n"]):
    """F0 + (1 - F0) (1 - cos)**5 from a reflectance F0 at cos = 1 to 1 at cos = 0 (Schlick 1994); F0 may be a colour of
    three channels, for a metal.
    """
    return straight * (1 - grazing(cosine)) + grazing(cosine)


def grazing(cosine: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """(1 - cos)**5, written out: a power with a fixed exponent is three products."""
    one = 1 - cosine
    square = one * one
    return square * square * one
