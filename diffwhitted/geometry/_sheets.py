"""Surfaces in one place: in which order rays meet them, and what lies between.

Two blocks that share a face, a glass on its coaster, a sphere in a hollow that it fills: the distances of their
surfaces differ by rounding alone. Such surfaces form a sheet (see `Sheets`), whose layers lie one on the other,
infinitely thin: a ray meets those that cover the point where it is, layer by layer, whatever the rounding.
"""

from collections.abc import Callable, Sequence

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..numerics._vector import Vec3, lookup, where
from ._edges import curvature_at
from ._footprint import Footprint
from ._hit import Hit
from ._ray import NOTHING, Departure, Ray, Sheets, sheet_at
from ._search import Shapes, surface_at

LAST = jnp.iinfo(jnp.int32).max


class Neighbours(eqx.Module):
    """The layers of a sheet around one of them, at points of it."""

    below: Int[Array, "n"]
    """The solid on the lower side of the sheet, -1 for none of it."""
    above: Int[Array, "n"]
    opaque: Bool[Array, "n"]
    """One of the layers is no medium."""
    more_below: Bool[Array, "n"]
    """There is a layer below this one."""
    more_above: Bool[Array, "n"]


def in_order(
    shapes: Shapes,
    ray: Ray,
    footprint: Footprint | None,
    departure: Departure,
    primitive: Int[Array, "n"],
    crossing: Int[Array, "n"],
    entering: Bool[Array, "n"] | None,
    cut: Bool[Array, "n"] | None,
) -> tuple[Int[Array, "n"], Int[Array, "n"], Bool[Array, "n"] | None, Bool[Array, "n"] | None]:
    """What a ray meets, where a search that knows no sheets has found a surface: its number, crossing and, where rays
    have a footprint, its side and whether its silhouette cuts the pixel.

    A ray that leaves a layer meets the next one, at no distance; else it meets the first layer of what was found.
    """
    hit = surface_at(shapes, ray, primitive, crossing, entering)
    none = jnp.zeros_like(hit.entering)
    round_cut = none if cut is None else cut & (curvature_at(shapes, hit) != 0)
    best = jnp.zeros_like(primitive), primitive, crossing, hit.entering, none if cut is None else cut
    best = _first(
        shapes, ray, footprint, departure, Departure(primitive, hit.entering), hit.point, best, round_cut, -LAST
    )
    nobody = jnp.full_like(primitive, LAST), jnp.full_like(primitive, NOTHING), crossing, none, none
    following = _first(shapes, ray, footprint, departure, departure, ray.origin, nobody, none, 1)
    # A ray that has run past another surface meanwhile is no longer on the one that it left.
    still, sheet = jnp.ones_like(none), sheet_at(_sheets(shapes), departure.primitive)
    for one in departure.passed:
        still = still & ((one == NOTHING) | (sheet_at(_sheets(shapes), one) == sheet))
    best = where(still & (following[1] >= 0), following, best)[1:]
    return best if footprint is not None else (*best[:2], None, None)


def _first(
    shapes: Shapes, ray: Ray, footprint, departure: Departure, at: Departure, point: Vec3, best, round_cut, least
):
    """The first layer that is `least` or more above `at`, in the way of the ray, and covers the point or part of the
    pixel; of round ones all are cut where one is.
    """
    sheets, upwards = _sheets(shapes), _upwards(shapes, at)
    may_pass = footprint is not None and departure.passed[-1] == NOTHING

    def closer(k, member, there, apart, best):
        entering = sheets.facing[k] != upwards
        cut = jnp.zeros_like(entering)
        if footprint is not None and member.FOOTPRINT:
            cut = (member.bordered(ray, footprint) & may_pass) | round_cut
        there = there & (member.covers(point) | cut) & ~departure.leaves_out(k)
        apart = jnp.where(upwards, apart, -apart)
        found = apart, jnp.full_like(best[1], k), member.crossing_at(entering), entering, cut
        return where(there & (apart >= least) & (apart < best[0]), found, best)

    return _over_sheet(shapes, at.primitive, closer, best)


def hidden_by_layers(
    shapes: Shapes, point: Vec3, departure: Departure, blocks: Sequence[bool] | Bool[Array, "surfaces"] | None
) -> Bool[Array, "n"]:
    """Does a layer, of those with `blocks` where that is given, cover the point on the side to which a ray leaves?"""

    def either(k, ahead, found):
        return found | (ahead if blocks is None else ahead & blocks[k])

    return _over_ahead(shapes, point, departure, either, jnp.zeros(point.shape, bool))


def layers_crossed(
    shapes: Shapes, point: Vec3, departure: Departure, kinds: Int[Array, "surfaces"], count: int
) -> tuple[Int[Array, "n"], ...]:
    """How many layers of each kind 0 .. `count` - 1 cover the point on the side to which a ray leaves."""

    def counted(k, ahead, totals):
        ahead = ahead & ~departure.leaves_out(k)
        return tuple(total + (ahead & (kinds[k] == kind)) for kind, total in enumerate(totals))

    return _over_ahead(shapes, point, departure, counted, (jnp.zeros(point.shape, jnp.int32),) * count)


def neighbours(
    shapes: Shapes, hit: Hit, rank: Int[Array, "objects"], clear: Callable[[Int[Array, ""]], Bool[Array, "n"]]
) -> Neighbours:
    """The layers around the one that was hit; `clear` tells for which points a surface bounds a medium.

    The solid on either side is that of the lowest rank of those whose inside is there.
    """
    sheets, point = _sheets(shapes), hit.point
    nobody, no = jnp.full(point.shape, NOTHING, jnp.int32), jnp.zeros(point.shape, bool)
    last = jnp.full(point.shape, LAST, jnp.int32)

    def asked(k, member, there, apart, found):
        (below, above), opaque, more_below, more_above = found
        there = there & (member.covers(point) | (hit.primitive == k))
        medium, number = there & clear(k), jnp.full_like(nobody, k)
        below = where(medium & sheets.facing[k] & (rank[k] < below[0]), (rank[k] + 0 * number, number), below)
        above = where(medium & ~sheets.facing[k] & (rank[k] < above[0]), (rank[k] + 0 * number, number), above)
        return (
            (below, above),
            opaque | (there & ~clear(k)),
            more_below | (there & (apart < 0)),
            more_above | (there & (apart > 0)),
        )

    first = ((last, nobody), (last, nobody)), no, no, no
    (below, above), *rest = _over_sheet(shapes, hit.primitive, asked, first)
    return Neighbours(below[1], above[1], *rest)


def _sheets(shapes: Shapes) -> Sheets:
    """Those of shapes where sheets are looked at."""
    assert shapes.sheets is not None
    return shapes.sheets


def _upwards(shapes: Shapes, at: Departure) -> Bool[Array, "n"]:
    """Does a ray on a surface go to the upper side of its sheet?"""
    return lookup(_sheets(shapes).facing, jnp.maximum(at.primitive, 0)) != at.inwards


def _over_ahead(shapes: Shapes, point: Vec3, departure: Departure, step: Callable, carry):
    """`carry = step(number, is it ahead, carry)` over all surfaces."""
    upwards = _upwards(shapes, departure)

    def one(k, member, there, apart, carry):
        return step(k, there & member.covers(point) & (jnp.where(upwards, apart, -apart) > 0), carry)

    return _over_sheet(shapes, departure.primitive, one, carry)


def _over_sheet(shapes: Shapes, primitive: Int[Array, "n"], step: Callable, carry):
    """`carry = step(number, surface, is it of the same sheet, layers above, carry)` over all surfaces."""
    sheets = _sheets(shapes)
    sheet, layer = sheet_at(sheets, primitive), lookup(sheets.layer, jnp.maximum(primitive, 0))
    for first, family in shapes.numbered():

        def one(k, member, carry, first=first):
            there = (sheet >= 0) & (sheets.sheet[first + k] == sheet)
            return step(first + k, member, there, sheets.layer[first + k] - layer, carry)

        carry = family.over(one, carry)
    return carry
