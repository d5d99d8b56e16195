"""The light of lamps that cannot reach a surface whose normals are bent."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics._safe import safe_divide
from ..numerics._vector import Vec3, dot
from ._surface_point import Bent, SurfacePoint


def above_horizon(bent: Bent, to_light: Vec3) -> Float[Array, "n"]:
    """The share of a lamp that wrinkles let through: 0 from behind the unbent surface, 1 where the lamp stands higher
    above it than the wrinkle is steep, 3 t**2 - 2 t**3 of the ratio t of the two sines between.

    So no light comes from behind, and none begins or ends in a jump. Edge: where nothing is bent it is 1.
    """
    height = dot(bent.unbent, to_light)
    t = jnp.where(height >= bent.horizon, 1, safe_divide(jnp.maximum(height, 0), bent.horizon))
    return jnp.where(bent.horizon > 0, t * t * (3 - 2 * t), 1)


def lit_above_horizon(point: SurfacePoint, to_light: Vec3) -> dict:
    """The coefficients that send a lamp back, less what wrinkles keep from the point."""
    if point.bent is None:
        return {}
    share = above_horizon(point.bent, to_light)
    return {name: point.coefficients[name] * share for name in ("k_d", "k_h") if name in point.coefficients}
