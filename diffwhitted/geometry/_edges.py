"""The searches where rays have a footprint: what an outline cuts counts in part.

A ray meets the nearest object that covers some of its pixel, also where its own line just misses it. A light is
hidden from a point by what covers all of the footprint there; what covers part of it is named, so that
its share can be computed with derivatives later.
"""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import Linear, is_cut
from ..numerics._vector import dot, lookup, where
from ._footprint import LEAST_COVERAGE, Footprint
from ._hit import Hit
from ._ray import NOTHING, Departure, Ray
from ._search import Shapes, fold


def near_outlines(shapes: Shapes, ray: Ray, reach, growth) -> Bool[Array, "n"]:
    """May the outline of some object lie within `reach` + `growth` times the distance of the ray's line?

    A quick look, which may say yes too often, so that the searches below are for few rays only.
    """
    return fold(
        shapes,
        lambda found, index, shape: found | shape.near_outline(ray, reach, growth),
        jnp.zeros(ray.origin.shape, bool),
    )


def beside_small(shapes: Shapes, ray: Ray, reach, growth, limit) -> Bool[Array, "n"]:
    """Does the ray pass, before `limit`, by an object so small that it may lie between it and the next, `reach` + `growth` times the distance away?"""

    def either(found, index, shape):
        middle, radius = shape.bounding()
        to_middle = middle - ray.origin
        along = dot(to_middle, ray.direction)
        miss = to_middle - ray.direction * along
        apart = reach + growth * abs(along)
        return found | (
            (along > 0) & (along < limit) & (radius < apart) & (dot(miss, miss) < (radius + apart) * (radius + apart))
        )

    return fold(shapes, either, jnp.zeros(ray.origin.shape, bool))


def nearest_part(shapes: Shapes, ray: Ray, footprint: Footprint, departure: Departure):
    """The nearest object that covers part of the pixel: its number (-1 for none), side, and whether its outline cuts the pixel.

    Where as many objects are left out already as a departure can name, outlines do not count.
    """
    zero = jnp.zeros(ray.origin.shape, ray.origin.dtype)
    may_pass = departure.passed[-1] == NOTHING

    def closer(best, index, shape):
        on_it, out = departure.object == index, departure.leaves_out(index)
        distance, entering = shape.first_crossing(ray, on_it, departure.inwards)
        outline, closest = shape.outline(ray, footprint)
        missed = jnp.isinf(distance)
        from_outside = missed | (entering == shape.side(ray))
        cut = is_cut(outline, LEAST_COVERAGE) & from_outside & (closest > 0) & ~on_it & may_pass
        distance = jnp.where(missed & cut, closest, distance)
        side = jnp.where(missed, shape.side(ray), entering)
        return where((distance < best[0]) & ~out, (distance, jnp.full_like(best[1], index), side, cut), best)

    start = (zero + jnp.inf, jnp.full(zero.shape, NOTHING, jnp.int32), zero > 0, zero > 0)
    return fold(shapes, closer, start, unrolled=1)[1:]


def hidden_parts(
    shapes: Shapes, ray: Ray, footprint: Footprint, departure: Departure, limit, blocks: tuple[bool, ...], most: int
) -> tuple[Bool[Array, "n"], tuple[Int[Array, "n"], ...]]:
    """Is the way to `limit` blocked for the whole footprint by an object with `blocks`, and which objects stand in
    part of it (`most` at most, -1 for none)? Further ones count whole or not at all."""
    nobody = jnp.full(ray.origin.shape, NOTHING, jnp.int32)
    opaque = jnp.asarray(blocks, bool)

    def either(found, index, shape):
        whole, parts = found
        on_it = departure.object == index
        distance, entering = shape.first_crossing(ray, on_it, departure.inwards)
        outline, closest = shape.outline(ray, footprint)
        from_outside = jnp.isinf(distance) | (entering == shape.side(ray))
        free = is_cut(outline, LEAST_COVERAGE) & from_outside & (closest > 0) & (closest < limit) & ~on_it
        cut, named = free & (parts[-1] == NOTHING), []
        for part in parts:
            take = free & (part == NOTHING)
            named.append(jnp.where(take, index, part))
            free = free & ~take
        return whole | ((distance < limit) & ~cut & opaque[index]), tuple(named)

    return fold(shapes, either, (nobody >= 0, (nobody,) * most), unrolled=1)


def outline_of(shapes: Shapes, ray: Ray, footprint: Footprint, object: Int[Array, "n"]) -> Linear:
    """The outline of a known object, differentiable; of no meaning for -1."""
    zero = jnp.zeros(ray.origin.shape, ray.origin.dtype)
    found = Linear(zero, zero, zero)
    for first, count, family in shapes.families():
        mine = (object >= first) & (object < first + count)
        outline, _ = lookup(family, jnp.where(mine, object - first, 0)).outline(ray, footprint)
        found = where(mine, outline, found)
    return found


def curvature_at(shapes: Shapes, hit: Hit) -> Float[Array, "n"]:
    """The unit normal of a hit, on the side of the ray, changes by this times a small step along the surface."""
    found = jnp.zeros(hit.object.shape, hit.point.dtype)
    for first, count, family in shapes.families():
        mine = (hit.object >= first) & (hit.object < first + count)
        found = jnp.where(mine, lookup(family.carrier(), jnp.where(mine, hit.object - first, 0)).curvature(), found)
    return jnp.where(hit.entering, found, -found)
