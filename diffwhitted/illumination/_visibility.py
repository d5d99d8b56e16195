"""What a point sees of a light: hard shadows, opaque or tinted by the glass on the way."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..geometry import Departure, Ray, Shapes, blocked, crossing_count
from ..numerics._safe import whole_powers
from ..numerics._vector import Vec3, lookup


def sees_light(shapes: Shapes, ray: Ray, departure: Departure, distance, blocks: tuple[bool, ...]) -> Bool[Array, "n"]:
    """Is the straight way to a light `distance` away free of the objects that block?"""
    return ~blocked(shapes, ray, departure, before(distance), blocks)


def surfaces_crossed(
    shapes: Shapes,
    ray: Ray,
    departure: Departure,
    distance,
    glass: tuple[bool, ...],
    but: tuple[Int[Array, "n"], ...] = (),
) -> Int[Array, "n"]:
    """How many surfaces of these transparent objects, except those numbered in `but`, lie on the straight way to the light."""
    return crossing_count(shapes, ray, Departure(departure.object, departure.inwards, but), before(distance), glass)


def tint(k_t: Vec3, crossed: Int[Array, "n"], most: int) -> Vec3:
    """k_t once for each surface crossed, of `most` at most, channel by channel; differentiable in k_t."""
    return Vec3(*(lookup(whole_powers(channel, most), crossed) for channel in (k_t.x, k_t.y, k_t.z)))


def before(distance):
    """A surface that carries the light itself does not block it: stop short by a few rounding errors."""
    return distance * (1 - 64 * jnp.finfo(distance.dtype).eps)
