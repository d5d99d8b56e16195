"""One way to ask all surfaces of a family: every one in turn, or those whose boxes a ray meets.

Whatever is asked, the answer is a fold over members whose order does not count, so that both searches give the same.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..numerics._safe import length
from ..numerics._stage import UNROLLED
from ..numerics._vector import Vec3, lookup
from ._boxes import BoxTree
from ._footprint import Footprint
from ._ray import NOTHING, Departure, Ray
from ._walk import walk

NARROW = 1e30
"""In place of 1 / 0 for a ray that runs along a side of its box."""


class Asked(eqx.Module):
    """What rays ask with, one entry a ray."""

    ray: Ray
    departure: Departure
    limit: Any = None
    """(n,): nothing from here on counts; None: all does."""
    footprint: Footprint | None = None
    reach: Any = None
    """(n,): what is no further from the ray's line than `reach` + `growth` times its distance counts too; None: it does
    not.
    """
    growth: Any = None
    extra: Any = None
    """What else a search has to know."""

    @classmethod
    def wide(cls, ray: Ray, reach, growth, limit=jnp.inf) -> "Asked":
        """Of rays in free space with something around them."""
        shape, dtype = ray.origin.shape, ray.origin.dtype
        reach, growth, limit = (jnp.broadcast_to(jnp.asarray(a, dtype), shape) for a in (reach, growth, limit))
        return cls(ray, free(shape), limit, None, reach, growth)

    @classmethod
    def over(cls, ray: Ray, footprint: Footprint, departure: Departure, limit) -> "Asked":
        """Of rays with a footprint."""
        return cls(ray, departure, limit, footprint, *footprint.reach())

    def start(self, k) -> tuple[Ray, Bool[Array, "n"], Bool[Array, "n"]]:
        """The ray, whether it starts on surface `k`, and on the inner side: what a crossing is asked with."""
        return self.ray, self.departure.starts_on(k), self.departure.inwards


def free(shape: tuple[int, ...]) -> Departure:
    """Of rays that start in free space."""
    return Departure(jnp.full(shape, NOTHING, jnp.int32), jnp.zeros(shape, bool))


def search(
    family: Any,
    boxes: BoxTree | None,
    meet: Callable,
    asked: Asked,
    found,
    nearest: Callable | None = None,
    content: Callable | None = None,
    unrolled: int = UNROLLED,
):
    """`found = meet(asked, found, number, member)` over the members of a family, or over those whose boxes a ray meets.

    `nearest(asked, found)`: nothing further away changes the answer; by default the limit of what is asked.
    `content(found)`: nothing at all does.
    """
    if boxes is None:
        return family.over(lambda k, member, found: meet(asked, found, k, member), found, unrolled)
    # What belongs to surfaces, not to rays, stays behind.
    sheet_of = asked.departure.sheet_of
    bare = replace(asked, departure=replace(asked.departure, sheet_of=None))

    def whole(asked: Asked) -> Asked:
        return replace(asked, departure=replace(asked.departure, sheet_of=sheet_of))

    def end(asked, found):
        if nearest is not None:
            return nearest(asked, found)
        return jnp.inf if asked.limit is None else asked.limit

    def enter(asked, found, low, high):
        return entry(asked, low, high, end(asked, found))

    def met(asked, found, number):
        return meet(whole(asked), found, number, lookup(family, number))

    idle = jnp.zeros(asked.ray.origin.shape, bool) if asked.limit is None else ~(asked.limit > 0)
    return walk(boxes, enter, met, content, bare, found, idle)


def entry(asked: Asked, low: Vec3, high: Vec3, limit) -> Float[Array, "n"]:
    """The distance at which rays enter boxes, those around them included; infinity where they do not before `limit`."""
    ray = asked.ray
    if asked.reach is not None:
        half = (high - low) * 0.5
        far = length(low + half - ray.origin) + length(half)
        apart = asked.reach + asked.growth * far
        around = Vec3(apart, apart, apart)
        low, high = low - around, high + around
    near, beyond = jnp.zeros_like(ray.origin.x), jnp.full_like(ray.origin.x, jnp.inf)
    for axis in ("x", "y", "z"):
        start, along = getattr(ray.origin, axis), getattr(ray.direction, axis)
        slope = jnp.where(along == 0, NARROW, 1 / jnp.where(along == 0, 1, along))
        one, other = (getattr(low, axis) - start) * slope, (getattr(high, axis) - start) * slope
        # By the sign of the direction, not of the difference: an empty box is met by nothing.
        near = jnp.maximum(near, jnp.where(slope < 0, other, one))
        beyond = jnp.minimum(beyond, jnp.where(slope < 0, one, other))
    beyond = beyond * (1 + 8 * jnp.finfo(beyond.dtype).eps)
    return jnp.where((near <= beyond) & (near < limit), near, jnp.inf)
