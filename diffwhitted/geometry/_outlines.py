"""Outlines of meshes in the footprint of rays: found by their sides, and looked at from both of their sides.

The nearest hit stays that of the search for surfaces. Where a side runs through the footprint, two more rays are sent:
one through the middle of the part of the pixel that the side says is covered, and one through the middle of the rest.
Only if they see what an outline shows, the mesh here and past it what lies behind, is the pixel divided. Where sides
are denser than footprints, or hidden, it is not, and the ray's own point stands for its pixel.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import is_cut
from ..numerics._safe import length
from ..numerics._stage import always, packed, stage
from ..numerics._vector import Vec3, lookup, where
from ._asking import Asked
from ._edges import silhouette_of
from ._footprint import LEAST_COVERAGE, Footprint, covered, edge_of, uncovered
from ._ray import NOTHING, Departure, Ray
from ._search import Shapes, blocked, nearest, surface_at
from ._sides import Passed, nearest_side, some_sides, triangle_of

AROUND = 64.0
"""An outline belongs to a surface that was met no more than so many footprints nearer."""


WIDE = 0.1
"""A footprint that reaches further than this share of what the meshes of a family span has no outline."""


class Found(eqx.Module):
    """Sides in the footprints of rays."""

    side: Int[Array, "n"]
    """Number of its triangle and its place there (see `side_of`), -1 for none."""
    neighbour: Int[Array, "n"]
    """The triangle on its other side, -1 for none."""
    distance: Float[Array, "n"]
    """Along the ray."""


def side_in(
    shapes: Shapes, ray: Ray, reach, growth: Float[Array, "n"], departure: Departure, limit, creases: bool
) -> Found:
    """The side of a mesh at which an outline, or a crease, runs through the footprint before the limit.

    A footprint that reaches further than `WIDE` of what the meshes of a family span has none.
    """
    nobody = jnp.full(ray.origin.shape, NOTHING, jnp.int32)
    found = Found(nobody, nobody, jnp.full(nobody.shape, jnp.inf, ray.origin.dtype))
    for (first, family), sided in zip(shapes.numbered(), shapes.sides, strict=True):
        if sided is None:
            continue
        sides, boxes = sided
        leaves = departure.counted_from(first)
        passed = Passed(tuple(end for one in leaves.passed for end in _ends(family, one)))
        end = limit
        if boxes is not None:
            low, high = boxes.around()
            away = length(low + (high - low) * 0.5 - ray.origin)
            end = jnp.where(reach + growth * away < WIDE * length(high - low), limit, 0)
        asked = Asked(ray, leaves, end, None, reach, growth, passed)
        number, distance = nearest_side(sides, boxes, asked, creases)
        there, mine = number >= 0, some_sides(sides, number)
        neighbour = jnp.where(mine.neighbour >= 0, mine.neighbour + first, NOTHING)
        nearer = there & (distance < found.distance)
        found = where(nearer, Found(mine.side + first, neighbour, distance), found)
    return found


def _ends(family, side: Int[Array, "n"]) -> tuple[Vec3, Vec3]:
    """The ends of sides by number; NaN for -1, and for what is no side of the family."""
    triangle, place = triangle_of(side)
    mine = (triangle >= 0) & (triangle < family.count)
    start, end, _ = lookup(family, jnp.where(mine, triangle, 0)).side(place)
    return where(mine, (start, end), (start * jnp.nan, end * jnp.nan))


def divided(
    shapes: Shapes,
    ray: Ray,
    footprint: Footprint,
    departure: Departure,
    distance: Float[Array, "n"],
    primitive: Int[Array, "n"],
    crossing: Int[Array, "n"],
    entering: Bool[Array, "n"],
    cut: Bool[Array, "n"],
    needed,
):
    """What rays meet, where the outline of a mesh may divide their pixel: the surface that its part sees, and which
    outline it is (-1: none); `distance` is that of what they meet.
    """

    def search(ray, footprint, departure, distance, cut):
        reach, growth = footprint.reach()
        met = jnp.isfinite(distance)
        far = jnp.where(met, distance, 0)
        limit = jnp.where(met, far + AROUND * (reach + growth * far), jnp.inf)
        asks = ~cut & (departure.passed[-1] == NOTHING)
        return side_in(shapes, ray, reach, growth, departure, jnp.where(asks, limit, 0), True)

    def look(ray, footprint, departure, found, primitive, crossing, entering):
        here = always(primitive)
        silhouette = stage(here, lambda *a: silhouette_of(shapes, *a), ray, footprint, found.side)
        edge = stage(here, edge_of, silhouette, primitive >= -1)
        inner, narrow = stage(here, covered, ray, footprint, edge)
        outer, _ = stage(here, uncovered, inner, narrow, edge)
        near, one, its_crossing = stage(here, lambda *a: nearest(shapes, *a), inner, departure)
        far, other, _ = stage(here, lambda *a: nearest(shapes, *a), outer, departure)
        del near
        enters = stage(here, lambda *a: surface_at(shapes, *a), inner, one, its_crossing).entering
        # See the mesh in the one part, and in the other what lies behind, or the triangle beyond a crease.
        triangle = triangle_of(found.side)[0]
        mesh, behind = shapes.object_at(triangle), shapes.object_at(other)
        crease = (one == triangle) & (other == found.neighbour)
        there = (shapes.object_at(one) == mesh) & ((behind != mesh) | (far > found.distance) | crease)
        there = there & is_cut(silhouette, LEAST_COVERAGE)
        seen = one, its_crossing, enters, there, found.side
        return where(there, seen, (primitive, crossing, entering, there, jnp.full_like(primitive, NOTHING)))

    found = stage(needed, search, ray, footprint, departure, distance, cut)
    whole = primitive, crossing, entering, cut, jnp.where(cut, primitive, NOTHING)
    some = found.side >= 0
    return packed(some, look, whole, ray, footprint, departure, found, primitive, crossing, entering)


def shaded_side(
    shapes: Shapes, ray: Ray, footprint: Footprint, departure: Departure, limit, blocks, sees, side, needed
) -> tuple[Bool[Array, "n"], Int[Array, "n"]]:
    """Is some of a footprint free on the way to `limit`, and the side of a mesh that hides part of it (-1 for none)?

    `sees`, `side`: the same without meshes; rays that name a `side` already are not asked. `blocks`: the surfaces that
    block light, None: all.
    """

    def search(ray, footprint, departure, limit, side):
        # The footprint grows narrower towards the light.
        leaves, reach = Departure(departure.primitive, departure.inwards), footprint.reach()[0]
        return side_in(shapes, ray, reach, reach * 0, leaves, jnp.where(side >= 0, 0, limit), False)

    def look(ray, footprint, departure, limit, found, sees):
        here = always(limit)
        silhouette = stage(here, lambda *a: silhouette_of(shapes, *a), ray, footprint, found)
        edge = stage(here, edge_of, silhouette, found >= -1)
        inner, narrow = stage(here, covered, ray, footprint, edge)
        outer, _ = stage(here, uncovered, inner, narrow, edge)

        def is_blocked(ray, departure, limit):
            return blocked(shapes, ray, departure, limit, blocks)

        hidden, open = (stage(here, is_blocked, one, departure, limit) for one in (inner, outer))
        there = hidden & ~open & is_cut(silhouette, LEAST_COVERAGE)
        there = there if blocks is None else there & lookup(blocks, triangle_of(found)[0])
        return sees | there, jnp.where(there, found, NOTHING)

    found = stage(needed, search, ray, footprint, departure, limit, side).side
    return packed(found >= 0, look, (sees, side), ray, footprint, departure, limit, found, sees)
