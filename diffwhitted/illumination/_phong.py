"""Phong's local illumination: what one light makes a point send back to the eye."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._safe import normalise, power_of_cosine
from .._vector import Vec3, dot
from ..optics import mirrored


def diffuse(normal: Vec3, to_light: Vec3) -> Float[Array, "*n"]:
    """Lambert's max(N.L, 0), the k_d term of Whitted (1)."""
    return jnp.maximum(dot(normal, to_light), 0)


def halfway_highlight(normal: Vec3, to_light: Vec3, incoming: Vec3, exponent: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """(N.H)**n with H the unit vector halfway between L and V = -u, the k_h term of Whitted (1).

    Zero where the light is at or behind the surface.
    """
    half = normalise(to_light - incoming)
    return _lit(normal, to_light, _lobe(normal, half, exponent))


def reflected_highlight(normal: Vec3, to_light: Vec3, incoming: Vec3, exponent: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """(V.R)**n with R the mirror direction of the light, Hearn and Baker (14-6).

    Computed as the angle between the light and the mirrored incoming ray, which is the same.
    Zero where the light is at or behind the surface.
    """
    return _lit(normal, to_light, _lobe(to_light, mirrored(incoming, normal), exponent))


def _lobe(a: Vec3, b: Vec3, exponent):
    apart = a - b
    return power_of_cosine(dot(apart, apart), exponent)


def _lit(normal: Vec3, to_light: Vec3, value):
    return jnp.where(dot(normal, to_light) > 0, value, 0)
