"""How a ray bends at a surface."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._safe import safe_divide, safe_sqrt
from .._vector import Vec3, dot


def mirrored(direction: Vec3, normal: Vec3) -> Vec3:
    """R = u - 2 (u.N) N (Hearn and Baker 14-49). The sign of the normal does not matter."""
    return direction - normal * (2 * dot(direction, normal))


def refraction_radicand(cos_i: Float[Array, "*n"], eta: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """cos_r**2 = 1 - eta**2 (1 - cos_i**2), the radicand of (14-51); negative at total internal reflection.

    Written as cos_i**2 + (1 - eta**2)(1 - cos_i**2), which is exactly cos_i**2 at eta = 1.
    """
    return cos_i * cos_i + (1 - eta) * (1 + eta) * (1 - cos_i * cos_i)


def refracted(direction: Vec3, normal: Vec3, eta: Float[Array, "*n"], radicand: Float[Array, "*n"] | None = None) -> Vec3:
    """T = eta u - (cos_r - eta cos_i) N (Hearn and Baker 14-50), N on the side of the incoming ray.

    `eta` is the index on the ray's side over the one on the far side; `radicand` may replace cos_r**2. Edges:
    at eta = 1 the ray goes straight on to the last digit or two; at the critical angle cos_r = 0 with
    derivative 0 (the one-sided limit is infinite). Past it the result has no meaning: see `refraction_radicand`.
    """
    cos_i = -dot(direction, normal)
    cos_r = safe_sqrt(refraction_radicand(cos_i, eta) if radicand is None else radicand)
    return direction * eta - normal * (cos_r - eta * cos_i)


def refracted_change(direction: Vec3, normal: Vec3, eta: Float[Array, "*n"], radicand: Float[Array, "*n"], turn: Vec3,
                     normal_turn: Vec3) -> Vec3:
    """Change of T where the direction changes by `turn` and the normal by `normal_turn` (Igehy 1999).

    The radicand may be another than that of the ray in the middle: a mean over the pixel keeps
    d cos_r = d(cos_r**2) / (2 cos_r) finite at the critical angle. Edge: 0 where the radicand is not positive.
    """
    cos_i = -dot(direction, normal)
    change_i = -(dot(turn, normal) + dot(direction, normal_turn))
    cos_r = safe_sqrt(radicand)
    change_r = safe_divide(eta * eta * cos_i * change_i, cos_r)
    return turn * eta - normal * (change_r - eta * change_i) - normal_turn * (cos_r - eta * cos_i)


def eta_at(entering, inside: Float[Array, "*n"], outside: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """Index on the ray's side over the index on the far side."""
    return jnp.where(entering, outside / inside, inside / outside)
