"""The one record between geometry and shading."""

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int

from ..numerics._vector import Vec3


class Hit(eqx.Module):
    """Where a ray meets a surface. Every field is finite, also where `object` is -1 (a miss)."""

    object: Int[Array, "*n"]
    """Index of the primitive, -1 where the ray meets nothing."""
    entering: Bool[Array, "*n"]
    """The ray comes from the outer side of the primitive."""
    point: Vec3
    normal: Vec3
    """Unit normal on the side of the incoming ray (zero for a miss)."""
    distance: Float[Array, "*n"]
    """Along the ray, in metres (zero for a miss)."""
