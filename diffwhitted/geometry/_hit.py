"""The one record between geometry and shading."""

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int

from ..numerics._vector import Vec3


class Hit(eqx.Module):
    """Where a ray meets a surface. Every field is finite, also for a miss, whose numbers are -1."""

    primitive: Int[Array, "*n"]
    """Which surface: an object may consist of many."""
    object: Int[Array, "*n"]
    """Which object, by which it has its name and its material."""
    crossing: Int[Array, "*n"]
    """Which of the crossings of the ray's line with that surface, counted along the ray (see
    `AbstractSurfaces.crossings`).
    """
    entering: Bool[Array, "*n"]
    """The ray comes from the outer side of the surface."""
    point: Vec3
    normal: Vec3
    """Geometric unit normal on the side of the incoming ray (zero for a miss): which side is which, and where rays
    may go.
    """
    shading_normal: Vec3
    """The normal that light sees: the geometric one, unless the surface interpolates or perturbs it."""
    distance: Float[Array, "*n"]
    """Along the ray, in metres (zero for a miss)."""
    lifted: Vec3 | None = None
    """From where shadow rays leave; None where no surface interpolates normals: from the point."""
    start: Vec3 | None = None
    """From where other rays go on; None where no surface is detached: from the point."""
    uv: tuple[Float[Array, "*n"], Float[Array, "*n"]] | None = None
    """Texture coordinates u and v that the surface brings along; None where no shape of the scene has any."""
