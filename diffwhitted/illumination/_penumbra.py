"""How much of a ball of light is seen past an outline, from one ray to its middle (Parker et al. 3.2)."""

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..geometry import Footprint, Ray, Shapes, silhouette_of
from ..numerics._safe import normalise, safe_divide, safe_sqrt
from ..numerics._vector import Vec3, cross, where

BLUR = 5 / 12
"""s over a half penumbra w averages with a kernel of variance w^2 / 5; a pixel over which the distance m changes by a
and b has the variance (a^2 + b^2) / 12. Both together are those of the half penumbra sqrt(w^2 + BLUR (a^2 + b^2))."""


def ball_beam(ray: Ray, size: Float[Array, "n"]) -> Footprint:
    """The rays from one point to a square around a ball: `size` is its radius over its distance."""
    u = ray.direction
    zero = jnp.zeros_like(u.x)
    # Cross with the axis that the ray is furthest from.
    flat_x, flat_y = abs(u.x) <= jnp.minimum(abs(u.y), abs(u.z)), abs(u.y) <= abs(u.z)
    axis = where(
        flat_x, Vec3(zero + 1, zero, zero), where(flat_y, Vec3(zero, zero + 1, zero), Vec3(zero, zero, zero + 1))
    )
    right = normalise(cross(u, axis))
    still = Vec3(zero, zero, zero)
    return Footprint(Ray(still, right * (2 * size)), Ray(still, cross(u, right) * (2 * size)))


def seen_of_ball(
    shapes: Shapes, ray: Ray, size: Float[Array, "n"], pixel: Footprint | None, occluder: Int[Array, "n"]
) -> Float[Array, "n"]:
    """s = tau^2 (3 - 2 tau), tau = (m + w) / (2 w) from 0 to 1; differentiable in ray, size and occluder.

    m is the distance of the ray's line from the occluder's outline (negative: it is covered), w = size t the half
    penumbra there, both along the normal of the outline. `pixel`: how the ray changes over the footprint, which widens
    the penumbra; None for points. Edges: outside of the penumbra the derivative is 0.
    """
    outline = silhouette_of(shapes, ray, ball_beam(ray, size), occluder)
    square = 0.25 * (outline.across * outline.across + outline.down * outline.down)
    if pixel is not None:
        move = silhouette_of(shapes, ray, pixel, occluder)
        square = square + BLUR * (move.across * move.across + move.down * move.down)
    half = safe_sqrt(square)
    tau = jnp.clip(0.5 - 0.5 * safe_divide(outline.value, half), 0, 1)
    return jnp.where(half > 0, tau * tau * (3 - 2 * tau), (outline.value <= 0).astype(tau.dtype))
