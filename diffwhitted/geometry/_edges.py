"""The searches where rays have a footprint: what a silhouette cuts counts in part.

A ray meets the nearest surface that covers some of its pixel, also where its own line just misses it. A light is
occluded from a point by what covers all of the footprint there; what covers part of it is named, so that
its coverage can be computed with derivatives later. Each family searches its own surfaces (see `AbstractSurfaces`).
"""

from functools import reduce

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import Linear
from ..numerics._vector import where
from ._footprint import Footprint
from ._hit import Hit
from ._ray import NOTHING, Departure, Ray, counted_from
from ._search import Shapes
from ._sides import triangle_of


def near_silhouettes(shapes: Shapes, ray: Ray, reach, growth) -> Bool[Array, "n"]:
    """May the silhouette of some surface lie within `reach` + `growth` times the distance of the ray's line?

    A quick look, which may say yes too often, so that the searches below are for few rays only.
    """
    found = (family.near_silhouettes(ray, reach, growth, boxes) for _, family, boxes in shapes.searched())
    return reduce(jnp.logical_or, found, jnp.zeros(ray.origin.shape, bool))


def beside_small(shapes: Shapes, ray: Ray, reach, growth, limit) -> Bool[Array, "n"]:
    """Does the ray pass, before `limit`, by a surface so small that it may lie between it and the next, `reach` +
    `growth` times the distance away?
    """
    found = (family.beside_small(ray, reach, growth, limit, boxes) for _, family, boxes in shapes.searched())
    return reduce(jnp.logical_or, found, jnp.zeros(ray.origin.shape, bool))


def nearest_part(shapes: Shapes, ray: Ray, footprint: Footprint, departure: Departure):
    """The nearest surface that covers part of the pixel: its number (-1 for none), crossing, side, and whether its
    silhouette cuts the pixel.

    Where as many surfaces are left out already as a departure can name, silhouettes do not count.
    """
    no = jnp.zeros(ray.origin.shape, bool)
    nobody = jnp.full(no.shape, NOTHING, jnp.int32)
    best = jnp.full(no.shape, jnp.inf, ray.origin.dtype), nobody, jnp.zeros(no.shape, jnp.int8), no, no
    for first, family, boxes in shapes.searched():
        leaves = departure.counted_from(first, shapes.sheets)
        distance, member, *rest = family.nearest_part(ray, footprint, leaves, boxes)
        best = where(distance < best[0], (distance, member + first, *rest), best)
    return best[1:]


def hidden_parts(
    shapes: Shapes,
    ray: Ray,
    footprint: Footprint,
    departure: Departure,
    limit,
    blocks: Bool[Array, "surfaces"] | None,
    most: int,
) -> tuple[Bool[Array, "n"], tuple[Int[Array, "n"], ...]]:
    """Is the way to `limit` blocked for the whole footprint by a surface (with `blocks`), and which surfaces stand in
    part of it (`most` at most, -1 for none)? Further ones count whole or not at all."""
    whole, parts = jnp.zeros(ray.origin.shape, bool), (jnp.full(ray.origin.shape, NOTHING, jnp.int32),) * most
    for first, family, boxes in shapes.searched():
        mine = tuple(counted_from(first, part) for part in parts)
        flags = shapes.part(blocks, first, family)
        leaves = departure.counted_from(first, shapes.sheets)
        whole, mine = family.hidden_parts(ray, footprint, leaves, limit, flags, (whole, mine), boxes)
        parts = tuple(jnp.where(m >= 0, m + first, part) for m, part in zip(mine, parts, strict=True))
    return whole, parts


def silhouette_of(shapes: Shapes, ray: Ray, footprint: Footprint, primitive: Int[Array, "n"]) -> Linear:
    """The silhouette of a known surface, or of a mesh along a known side, differentiable; of no meaning for -1."""
    zero = jnp.zeros(ray.origin.shape, ray.origin.dtype)
    found = Linear(zero, zero, zero)
    for mine, member in shapes.members(shapes.named(primitive)):
        if member.SIDED:
            if shapes.sides:
                found = where(mine, member.outline(triangle_of(primitive)[1], ray, footprint)[0], found)
        elif member.FOOTPRINT:
            found = where(mine, member.silhouette(ray, footprint)[0], found)
    return found


def curvature_at(shapes: Shapes, hit: Hit) -> Float[Array, "n"]:
    """The unit normal of a hit, on the side of the ray, changes by this times a small step along the surface."""
    found = jnp.zeros(hit.primitive.shape, hit.point.dtype)
    for mine, member in shapes.members(hit.primitive, lambda family: family.carrier()):
        found = jnp.where(mine, member.curvature(), found)
    return jnp.where(hit.entering, found, -found)
