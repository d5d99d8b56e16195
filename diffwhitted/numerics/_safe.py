"""Arithmetic that stays finite at its edges, in value and in both derivative modes.

Nothing else in the renderer calls a square root, a norm, a division or a power with a variable
exponent on something that may be masked. The rule is the same everywhere: the *input* is replaced
by a harmless one where the operation is not defined, so that no infinity is ever formed and then
multiplied by zero on the way back.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ._vector import Vec3, dot


def safe_sqrt(x: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """Square root of max(x, 0).

    Edge: for x <= 0 the value is 0 and the derivative is 0 (the one-sided limit is infinite).
    """
    positive = x > 0
    return jnp.where(positive, jnp.sqrt(jnp.where(positive, x, 1)), 0)


def safe_divide(a: Float[Array, "*n"] | float, b: Float[Array, "*n"], otherwise: float = 0) -> Float[Array, "*n"]:
    """a / b.

    Edge: where b = 0 the value is `otherwise`, and the derivatives in a and b are 0.
    """
    defined = b != 0
    return jnp.where(defined, a / jnp.where(defined, b, 1), otherwise)


def length(v: Vec3) -> Float[Array, "*n"]:
    """|v|. Edge: 0 with derivative 0 at the zero vector."""
    return safe_sqrt(dot(v, v))


def normalise(v: Vec3) -> Vec3:
    """v / |v|. Edge: the zero vector stays zero, with derivative 0."""
    return v * safe_divide(1, length(v))


def rescaled(v: Vec3) -> tuple[Vec3, Float[Array, "*n"]]:
    """v times a power of two, and that power, for a v of any length: the largest component becomes about 1.

    The power is exact, so no digit of v changes, and a derivative takes it as a constant. For what a user
    writes: squares of very short or long vectors leave the range of float32.
    """
    power = power_of_two(jax.lax.stop_gradient(jnp.maximum(jnp.maximum(abs(v.x), abs(v.y)), abs(v.z))))
    return v * power, power


def power_of_two(size: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """The power of two that makes a size about 1; it is exact to multiply with."""
    tiny = float(jnp.finfo(size.dtype).tiny)
    return 1 / jnp.clip(safe_divide(size, jnp.frexp(size)[0]), tiny, 1 / tiny)


def power_of_cosine(chord_squared: Float[Array, "*n"], exponent: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """max(cos, 0) ** exponent for the angle between two unit vectors |a - b|**2 = `chord_squared` apart.

    cos = 1 - |a - b|**2 / 2, so log cos = log1p(-|a - b|**2 / 2) keeps its digits where the cosine
    is close to 1: a Phong exponent of 1e6 is exact in float32, where `cos ** n` is off by 6 %.

    Edges: for cos <= 0 the value is 0 (1 where the exponent is 0, as 0 ** 0 = 1); the derivatives in
    the cosine and in the exponent are 0 there.
    """
    lit = chord_squared < 2
    log_cosine = jnp.log1p(-0.5 * jnp.where(lit, chord_squared, 0))
    return jnp.where(lit, jnp.exp(exponent * log_cosine), jnp.where(exponent == 0, 1, 0).astype(chord_squared.dtype))
