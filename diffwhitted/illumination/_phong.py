"""Phong's local illumination: what one light makes a point send back to the eye."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._safe import normalise, power_of_cosine
from .._vector import Vec3, dot
from ..optics import mirrored


def diffuse(normal: Vec3, to_light: Vec3) -> Float[Array, "*n"]:
    """Lambert's max(N.L, 0), the k_d term of Whitted (1)."""
    return jnp.maximum(dot(normal, to_light), 0)


def lit(normal: Vec3, to_light: Vec3) -> Float[Array, "*n"]:
    """1 where the light is before the surface, 0 where it is in its plane or behind: what a highlight is multiplied by."""
    return (dot(normal, to_light) > 0).astype(normal.dtype)


def halfway_highlight(normal: Vec3, to_light: Vec3, incoming: Vec3, exponent: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """(N.H)**n with H the unit vector halfway between L and V = -u, the k_h term of Whitted (1), to be multiplied by `lit`."""
    return _lobe(normal, normalise(to_light - incoming), exponent)


def reflected_highlight(normal: Vec3, to_light: Vec3, incoming: Vec3, exponent: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """(V.R)**n with R the mirror direction of the light, Hearn and Baker (14-6), to be multiplied by `lit`.

    Computed as the angle between the light and the mirrored incoming ray, which is the same.
    """
    return _lobe(to_light, mirrored(incoming, normal), exponent)


def _lobe(a: Vec3, b: Vec3, exponent):
    apart = a - b
    return power_of_cosine(dot(apart, apart), exponent)

