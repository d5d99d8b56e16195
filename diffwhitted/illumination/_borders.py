"""What part of a point, or of its footprint, lies within the edges of a lamp's light."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics._coverage import Linear, coverage
from ..numerics._safe import safe_divide, safe_sqrt
from ..scene import AbstractLight, Border
from ._surface_point import SurfacePoint

BLUR = 5 / 3
"""s^2 (3 - 2 s) over a width w averages with a kernel of variance w^2 / 20; a pixel over which the value changes by a
and b has the variance (a^2 + b^2) / 12. Both together are those of the width sqrt(w^2 + BLUR (a^2 + b^2))."""


def within_borders(light: AbstractLight, point: SurfacePoint) -> Float[Array, "n"] | float:
    """The part of the light that its own edges leave; differentiable.

    Edges: of points, a hard edge has derivative 0; where rays have a footprint it is the share of the pixel within it,
    exact where the edge is straight, and the derivative is that of the edge's move. A soft edge is widened by the
    footprint. Sets of edges multiply.
    """
    part, borders = 1.0, light.borders(point.position)
    steps = None
    if point.footprint is not None:
        # Find how the edges change over the sides of the pixel.
        steps = [jax.jvp(light.borders, (point.position,), (side.origin,))[1] for side in point.footprint.sides()]
    for number, parallel in enumerate(borders):
        outside = 0.0
        for k, border in enumerate(parallel):
            across, down = (0.0, 0.0) if steps is None else (step[number][k].value for step in steps)
            inside = _hard(border, across, down) if border.width is None else _soft(border, across, down)
            outside = outside + (1 - inside)
        # Edges that run side by side cut off parts that do not overlap.
        part = part * jnp.maximum(1 - outside, 0)
    return part


def _hard(border: Border, across, down) -> Float[Array, "n"]:
    zero = jnp.zeros_like(border.value)
    return coverage(Linear(border.value, zero + across, zero + down))


def _soft(border: Border, across, down) -> Float[Array, "n"]:
    """The smooth step about the middle of the edge; a hard one where it has no width at all."""
    width = jnp.maximum(border.width, 0)
    wide = safe_sqrt(width * width + BLUR * (across * across + down * down))
    share = jnp.clip(0.5 + safe_divide(border.value - 0.5 * width, wide), 0, 1)
    return jnp.where(wide > 0, share * share * (3 - 2 * share), (border.value > 0).astype(share.dtype))
