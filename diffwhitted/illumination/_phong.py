"""Phong's local illumination: what one light makes a point send back to the eye."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics._safe import power_of_cosine
from ..numerics._vector import Vec3, dot


def diffuse(normal: Vec3, to_light: Vec3) -> Float[Array, "*n"]:
    """Lambert's max(N.L, 0), the k_d term of Whitted (1)."""
    return jnp.maximum(dot(normal, to_light), 0)


def lit(normal: Vec3, to_light: Vec3) -> Float[Array, "*n"]:
    """1 where the light is before the surface, 0 where it is in its plane or behind: what a highlight is multiplied
    by.
    """
    return (dot(normal, to_light) > 0).astype(normal.dtype)


def lobe(apart: Vec3, exponent: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """cos**n of the angle between two unit vectors with this difference, to be multiplied by `lit`."""
    return power_of_cosine(dot(apart, apart), exponent)


def lobe_mean(apart: Vec3, across: Vec3, down: Vec3, exponent: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """The mean of the lobe over a pixel along whose sides the difference changes by `across` and `down`.

    Near its top cos**n is a Gaussian of variance 1/n (cos**n = exp(-n angle**2 / 2)); averaged over angles that spread
    with variance s it is one of variance 1/n + s, as high as its volume allows: m/n cos**m with m = n / (1 + n s).
    After Toksvig 2005, Mipmapping normal maps.
    """
    variance = (dot(across, across) + dot(down, down)) / 24
    narrower = 1 / (1 + exponent * variance)
    return narrower * lobe(apart, exponent * narrower)
