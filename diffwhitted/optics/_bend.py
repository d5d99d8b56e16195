"""How a ray bends at a surface."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..numerics._coverage import Linear
from ..numerics._safe import normalise, safe_divide, safe_sqrt
from ..numerics._vector import Vec3, dot, where


def mirrored(direction: Vec3, normal: Vec3) -> Vec3:
    """R = u - 2 (u.N) N (Hearn and Baker 14-49). The sign of the normal does not matter."""
    return direction - normal * (2 * dot(direction, normal))


STEEP = 4.0
"""Ratio of indices above which refraction is reckoned from the sine: the usual form loses the digits of eta**2."""


def along_surface(direction: Vec3, normal: Vec3) -> Vec3:
    """u + cos_i N, the part of a direction in the tangent plane; as long as the sine of the angle of incidence."""
    return direction - normal * dot(direction, normal)


def sine_squared(direction: Vec3, normal: Vec3, eta: Float[Array, "..."] | float) -> Float[Array, "..."]:
    """sin_i**2 of the angle of incidence: 1 - cos_i**2, and for a steep ratio of indices from the sine itself."""
    cosine, along = dot(direction, normal), along_surface(direction, normal)
    return jnp.where(eta > STEEP, dot(along, along), 1 - cosine * cosine)


def refraction_radicand(
    cos_i: Float[Array, "*n"], eta: Float[Array, "..."] | float, sine_squared: Float[Array, "..."] | None = None
) -> Float[Array, "..."]:
    """cos_r**2 = 1 - eta**2 sin_i**2, the radicand of (14-51); negative at total internal reflection.

    Written as cos_i**2 + (1 - eta**2) sin_i**2, which is exactly cos_i**2 at eta = 1. Without `sine_squared` (see
    there) it is 1 - cos_i**2, whose rounding an eta of 1000 makes a million times larger.
    """
    if sine_squared is None:
        sine_squared = 1 - cos_i * cos_i
    return cos_i * cos_i + (1 - eta) * (1 + eta) * sine_squared


def refracted(direction: Vec3, normal: Vec3, eta: Float[Array, "..."] | float) -> Vec3:
    """T = eta u - (cos_r - eta cos_i) N (Hearn and Baker 14-50), N on the side of the incoming ray.

    `eta` is the index on the ray's side over the one on the far side. Edges: at eta = 1 the ray goes
    straight on to the last digit or two; at the critical angle cos_r = 0 with derivative 0 (the one-sided
    limit is infinite). Past it the result has no meaning: see `refraction_radicand`. Above `STEEP` it is
    eta (u + cos_i N) - cos_r N, made as long as 1.
    """
    cos_i = -dot(direction, normal)
    cos_r = safe_sqrt(refraction_radicand(cos_i, eta, sine_squared(direction, normal, eta)))
    bent = direction * eta - normal * (cos_r - eta * cos_i)
    steep = normalise(along_surface(direction, normal) * eta - normal * cos_r)
    return where(eta > STEEP, steep, bent)


class Turn(eqx.Module):
    """A direction after a surface, a u + b N, to first order over a pixel.

    A mirror has a = 1, b = 2 cos_i; glass has a = eta, b = eta cos_i - cos_r.
    """

    along: Float[Array, "*n"]
    normal: Float[Array, "*n"]
    across: Float[Array, "*n"]
    """Change of b along the row of the pixel."""
    down: Float[Array, "*n"]

    def direction(self, incoming: Vec3, normal: Vec3) -> Vec3:
        bent = incoming * self.along + normal * self.normal
        return where(self.along > STEEP, normalise(bent), bent)

    def change(self, turn: Vec3, normal_turn: Vec3, normal: Vec3, of_b: Float[Array, "*n"]) -> Vec3:
        """Change of the direction if the incoming changes by `turn` and the normal by `normal_turn` (Igehy 1999)."""
        return turn * self.along + normal * of_b + normal_turn * self.normal


def turn_at(
    cosine: Linear,
    eta: Float[Array, "*n"] | None = None,
    radicand: Float[Array, "*n"] | None = None,
    through: Bool[Array, "*n"] | None = None,
) -> Turn:
    """Mirrored, or refracted where `through`, for cos_i over a pixel.

    The radicand cos_r**2 may be another than that of the ray in the middle: a mean over the pixel keeps
    d b = (eta - eta**2 cos_i / cos_r) d cos_i finite at the critical angle. Edge: the second term is 0 where the
    radicand is not positive.
    """
    along, normal, slope = 1.0, 2 * cosine.value, 2.0
    if eta is not None:
        cos_r = safe_sqrt(radicand)
        along = jnp.where(through, eta, along)
        normal = jnp.where(through, eta * cosine.value - cos_r, normal)
        slope = jnp.where(through, eta - safe_divide(eta * eta * cosine.value, cos_r), slope)
    return Turn(along * jnp.ones_like(cosine.value), normal, cosine.across * slope, cosine.down * slope)


def eta_at(
    entering: Bool[Array, "*n"], inside: Float[Array, "..."] | float, outside: Float[Array, "..."] | float
) -> Float[Array, "..."]:
    """Index on the ray's side over the index on the far side."""
    return jnp.where(entering, outside / inside, inside / outside)
