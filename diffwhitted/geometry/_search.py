"""All surfaces of a scene under one numbering, and the searches over them.

The numbering runs through the families in their order. Each family searches its own surfaces (see
`AbstractSurfaces`); here the answers of the families are put together.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._safe import normalise
from ..numerics._stage import repeated
from ..numerics._vector import Vec3, dot, lookup, where
from ._boxes import BoxTree
from ._compiled import searcher
from ._hit import Hit
from ._ray import NOTHING, Departure, Ray, Sheets
from ._sides import Sides, triangle_of
from ._surface import AbstractSurfaces

GRAZING = 1e-3
"""Cosine of the largest angle between an interpolated normal and the way back along a ray."""


class Shapes(eqx.Module):
    """The families of surfaces in a scene."""

    families: tuple[AbstractSurfaces, ...]
    object_of: Int[Array, "surfaces"] | None = None
    """The object that each surface belongs to; None where each is an object of its own."""

    sheets: Sheets | None = None
    """Which surfaces lie in one place; None where that is not looked at."""
    boxes: tuple[BoxTree | None, ...] = ()
    """For each family the tree of boxes by which it is searched; None, or none at all: every surface is asked."""
    surfaces_of: tuple[Int[Array, "objects"], Int[Array, "objects"]] | None = None
    """The first surface of each object, and how many it has; None where each object is one."""
    sides: tuple[tuple[Sides, BoxTree | None] | None, ...] = ()
    """For each family of triangles their sides, and the tree by which these are searched; empty where no rays have
    footprints, or no family has any.
    """

    def searched(self) -> Iterator[tuple[int, AbstractSurfaces, BoxTree | None]]:
        """(number of its first surface, family, the tree by which it is searched) for each family."""
        for k, (first, family) in enumerate(self.numbered()):
            yield first, family, self.boxes[k] if self.boxes else None

    def numbered(self) -> Iterator[tuple[int, AbstractSurfaces]]:
        """(number of its first surface, family) for each family."""
        first = 0
        for family in self.families:
            yield first, family
            first += family.count

    def members(self, primitive: Int[Array, "*n"], of: Callable = lambda family: family) -> Iterator[tuple]:
        """For each family: which of the known surfaces are its own, and for each ray that member of it (or of what `of`
        makes of the family); some other one, of no meaning, for the rest."""
        for first, family in self.numbered():
            mine = (primitive >= first) & (primitive < first + family.count)
            yield mine, lookup(of(family), jnp.where(mine, primitive - first, 0))

    @property
    def count(self) -> int:
        return sum(family.count for family in self.families)

    def named(self, number: Int[Array, "*n"]) -> Int[Array, "*n"]:
        """The surfaces whose outlines are known by these numbers: those of triangles by one of their sides."""
        return triangle_of(number)[0] if self.sides else number

    def part(self, flags, first: int, family: AbstractSurfaces) -> Any:
        """Of one value a surface, those of a family; None stays None."""
        return None if flags is None else flags[first : first + family.count]

    def object_at(self, primitive: Int[Array, "*n"]) -> Int[Array, "*n"]:
        """The object of each surface; -1 for -1."""
        if self.object_of is None:
            return primitive
        return jnp.where(primitive >= 0, lookup(self.object_of, jnp.maximum(primitive, 0)), NOTHING)

    def by_surface(self, flags):
        """One value a surface, of one value an object; None stays None."""
        return flags if self.object_of is None or flags is None else lookup(flags, self.object_of)

    def first_surface(self, object: Int[Array, "*n"]) -> Int[Array, "*n"]:
        """The number of the first surface of an object; -1 for -1."""
        if self.surfaces_of is None:
            return object
        return jnp.where(object >= 0, lookup(self.surfaces_of[0], jnp.maximum(object, 0)), NOTHING)


def nearest(
    shapes: Shapes, ray: Ray, departure: Departure
) -> tuple[Float[Array, "n"], Int[Array, "n"], Int[Array, "n"]]:
    """Distance (infinity on a miss), number (-1 on a miss) and crossing of the first surface ahead."""
    distance = jnp.full(ray.origin.shape, jnp.inf, ray.origin.dtype)
    best = distance, jnp.full(distance.shape, NOTHING, jnp.int32), jnp.zeros(distance.shape, jnp.int8)
    for first, family, boxes in shapes.searched():
        leaves, by = departure.counted_from(first, shapes.sheets), searcher(family, boxes, shapes.sheets)
        distance, member, crossing = by.nearest(ray, leaves, boxes)
        best = where(distance < best[0], (distance, member + first, crossing), best)
    return best


def blocked(
    shapes: Shapes, ray: Ray, departure: Departure, limit, blocks: Sequence[bool] | Bool[Array, "surfaces"] | None
) -> Bool[Array, "n"]:
    """Does a surface, of those with `blocks` where that is given, lie on the ray nearer than `limit`?"""
    found = (
        searcher(family, boxes, shapes.sheets).blocked(
            ray, departure.counted_from(first, shapes.sheets), limit, shapes.part(blocks, first, family), boxes
        )
        for first, family, boxes in shapes.searched()
    )
    return reduce(jnp.logical_or, found, jnp.zeros(ray.origin.shape, bool))


def crossing_counts(
    shapes: Shapes, ray: Ray, departure: Departure, limit, kinds: Int[Array, "surfaces"], count: int
) -> tuple[Int[Array, "n"], ...]:
    """How many surfaces of each kind 0, 1, ... `count` - 1 the ray crosses before `limit`; -1 is of no kind."""
    totals = (jnp.zeros(ray.origin.shape, jnp.int32),) * count
    for first, family, boxes in shapes.searched():
        leaves, mine = departure.counted_from(first, shapes.sheets), shapes.part(kinds, first, family)
        # Machine code knows of no surfaces that a ray runs past.
        by = family if departure.passed and not family.SIDED else searcher(family, boxes, shapes.sheets)
        found = by.crossing_counts(ray, leaves, limit, mine, count, boxes)
        totals = tuple(total + more for total, more in zip(totals, found, strict=True))
    return totals


def containing(
    shapes: Shapes,
    point: Vec3,
    solids: Sequence[Int[Array, "_"]],
    rank: Int[Array, "objects"],
    but: Int[Array, "n"],
    counted: Callable[[Int[Array, ""]], Bool[Array, "n"]] | None = None,
) -> Int[Array, "n"]:
    """The solid of the lowest rank that holds the point, leaving out the one named in `but`; -1 if none does.

    `solids`: for each family the numbers of the solids to be asked, -1 in the room to spare. With the smallest first,
    this is the innermost of nested solids. `counted` tells for which points the solid of a number counts; all by
    default.
    """
    last = jnp.iinfo(jnp.int32).max
    best = jnp.full(point.shape, last, jnp.int32), jnp.full(point.shape, NOTHING, jnp.int32)
    for (first, family, boxes), numbers in zip(shapes.searched(), solids, strict=True):

        def ask(k, best, first=first, family=family, boxes=boxes, numbers=numbers):
            number = numbers[k]
            its_first = jnp.maximum(shapes.first_surface(number) - first, 0)
            many = 1 if shapes.surfaces_of is None else shapes.surfaces_of[1][jnp.maximum(number, 0)]
            inner = family.holds(its_first, many, point, boxes)
            inner = inner & (but != number) & (number >= 0) & (rank[number] < best[0])
            inner = inner if counted is None else inner & counted(number)
            return where(inner, (rank[number], number), best)

        best = repeated(numbers.shape[0], ask, best)
    return best[1]


def surface_at(
    shapes: Shapes,
    ray: Ray,
    primitive: Int[Array, "n"],
    crossing: Int[Array, "n"],
    entering: Bool[Array, "n"] | None = None,
) -> Hit:
    """The hit on a known surface at a known crossing, differentiable in the ray and the surface.

    `entering`, where it is known, decides the side of the ray. A miss (-1) gets distance 0 and a zero normal, so that
    nothing infinite enters a derivative.
    """
    zero = jnp.zeros(ray.origin.shape, ray.origin.dtype)
    black = Vec3(zero, zero, zero)
    found, bent = (zero, black, ray.origin, jnp.zeros(zero.shape, bool)), (black, ray.origin, ray.origin)
    smooth, worn = (any(getattr(family, what) for family in shapes.families) for what in ("interpolated", "has_uv"))
    uv = (zero, zero) if worn else None
    start = ray.origin if any(family.DETACHED for family in shapes.families) else None
    for mine, member in shapes.members(primitive, lambda family: family.carrier()):
        met = member.surface(ray, crossing)
        found = where(mine, met, found)
        bent = where(mine, member.shading(ray, met[2], met[1]), bent) if smooth else bent
        start = None if start is None else where(mine, bent[1] if member.DETACHED else met[2], start)
        uv = where(mine, member.uv(met[2]), uv) if worn else None
    distance, outward, point, enters = found
    enters = enters if entering is None else entering
    normal = where(enters, outward, -outward)
    if not smooth:
        return Hit(primitive, shapes.object_at(primitive), crossing, enters, point, normal, normal, distance, uv=uv)
    shading = where(primitive >= 0, towards(ray.direction, where(enters, bent[0], -bent[0])), black)
    lifted = where(enters, bent[1], bent[2])
    object = shapes.object_at(primitive)
    return Hit(primitive, object, crossing, enters, point, normal, shading, distance, lifted, start, uv)


def uv_at(shapes: Shapes, primitive: Int[Array, "n"], point: Vec3) -> tuple[Float[Array, "n"], Float[Array, "n"]]:
    """The texture coordinates that known surfaces bring along, at points of them, differentiable; 0 where there are
    none.
    """
    zero = jnp.zeros_like(point.x)
    uv = zero, zero
    for mine, member in shapes.members(primitive, lambda family: family.carrier()):
        uv = where(mine, member.uv(point), uv)
    return uv


def towards(direction: Vec3, normal: Vec3) -> Vec3:
    """An interpolated normal that faces the ray: one that is turned away, as near an outline, is bent until it is
    `GRAZING` to the ray.
    """
    away = jnp.maximum(dot(direction, normal) + GRAZING, 0)
    return where(away > 0, normalise(normal - direction * away), normal)


def on_its_side(direction: Vec3, normal: Vec3, through: Bool[Array, "n"]) -> Vec3:
    """A direction that was bent at an interpolated normal, on the side of the surface on which the ray goes on: what
    would lie on the other side is turned until it grazes the surface.
    """
    side = where(through, -normal, normal)
    short = jnp.maximum(GRAZING - dot(direction, side), 0)
    return where(short > 0, normalise(direction + side * short), direction)
