"""What a point sees of a light: hard shadows, opaque or tinted by the glass on the way."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..geometry import Departure, Ray, Shapes, blocked, crossing_counts
from ..numerics._vector import Vec3


def sees_light(
    shapes: Shapes, ray: Ray, departure: Departure, distance, blocks: Bool[Array, "surfaces"] | None
) -> Bool[Array, "n"]:
    """Is the straight way to a light `distance` away free of the surfaces that block (all, where `blocks` is None)?"""
    return ~blocked(shapes, ray, departure, before(distance), blocks)


def glass_crossed(
    shapes: Shapes,
    ray: Ray,
    departure: Departure,
    distance,
    glass_of: Int[Array, "surfaces"],
    count: int,
    but: tuple[Int[Array, "n"], ...] = (),
) -> tuple[Int[Array, "n"], ...]:
    """How many surfaces of each of the `count` transparent materials, except those numbered in `but`, lie on the
    straight way to the light.
    """
    leaving = Departure(departure.primitive, departure.inwards, but)
    found = crossing_counts(shapes, ray, leaving, before(distance), glass_of, count)
    return tuple(number.astype(jnp.int16 if count_bits(shapes) < 16 else jnp.int32) for number in found)


def count_bits(shapes: Shapes) -> int:
    """Bits that hold how many surfaces a straight line may cross."""
    return sum(family.crossed_at_most for family in shapes.families).bit_length()


def tint(k_t: Vec3, crossed: Int[Array, "n"], bits: int) -> Vec3:
    """k_t once for each surface crossed, channel by channel; differentiable in k_t, also at 0."""
    return Vec3(*(whole_power(channel, crossed, bits) for channel in (k_t.x, k_t.y, k_t.z)))


def whole_power(base: Float[Array, ""], exponent: Int[Array, "n"], bits: int) -> Float[Array, "n"]:
    """base ** exponent for whole exponents below 2 ** bits, by repeated squaring.

    Edges: base ** 0 = 1 with derivative 0, also at base = 0; 0 ** 1 has derivative 1.
    """
    power, square = jnp.ones(exponent.shape, base.dtype), base
    for bit in range(bits):
        power = jnp.where((exponent >> bit) & 1 > 0, power * square, power)
        square = square * square
    return power


def before(distance):
    """A surface that carries the light itself does not block it: stop short by a few rounding errors."""
    return distance * (1 - 64 * jnp.finfo(distance.dtype).eps)
