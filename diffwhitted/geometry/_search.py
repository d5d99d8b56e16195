"""All surfaces of a scene under one numbering, and the searches over them.

The numbering runs through the families in their order. Each family searches its own surfaces (see
`AbstractSurfaces`); here the answers of the families are put together.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._stage import repeated
from ..numerics._vector import Vec3, lookup, where
from ._hit import Hit
from ._ray import NOTHING, Departure, Ray, Sheets
from ._surface import AbstractSurfaces


class Shapes(eqx.Module):
    """The families of surfaces in a scene."""

    families: tuple[AbstractSurfaces, ...]
    object_of: Int[Array, "surfaces"] | None = None
    """The object that each surface belongs to; None where each is an object of its own."""

    sheets: Sheets | None = None
    """Which surfaces lie in one place; None where that is not looked at."""

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

    def part(self, flags, first: int, family: AbstractSurfaces) -> Any:
        """Of one value a surface, those of a family; None stays None."""
        return None if flags is None else flags[first : first + family.count]

    def object_at(self, primitive: Int[Array, "*n"]) -> Int[Array, "*n"]:
        """The object of each surface; -1 for -1."""
        if self.object_of is None:
            return primitive
        return jnp.where(primitive >= 0, lookup(self.object_of, jnp.maximum(primitive, 0)), NOTHING)


def nearest(
    shapes: Shapes, ray: Ray, departure: Departure
) -> tuple[Float[Array, "n"], Int[Array, "n"], Int[Array, "n"]]:
    """Distance (infinity on a miss), number (-1 on a miss) and crossing of the first surface ahead."""
    distance = jnp.full(ray.origin.shape, jnp.inf, ray.origin.dtype)
    best = distance, jnp.full(distance.shape, NOTHING, jnp.int32), jnp.zeros(distance.shape, jnp.int8)
    for first, family in shapes.numbered():
        distance, member, crossing = family.nearest(ray, departure.counted_from(first, shapes.sheets))
        best = where(distance < best[0], (distance, member + first, crossing), best)
    return best


def blocked(
    shapes: Shapes, ray: Ray, departure: Departure, limit, blocks: Sequence[bool] | Bool[Array, "surfaces"] | None
) -> Bool[Array, "n"]:
    """Does a surface, of those with `blocks` where that is given, lie on the ray nearer than `limit`?"""
    found = (
        family.blocked(ray, departure.counted_from(first, shapes.sheets), limit, shapes.part(blocks, first, family))
        for first, family in shapes.numbered()
    )
    return reduce(jnp.logical_or, found, jnp.zeros(ray.origin.shape, bool))


def crossing_counts(
    shapes: Shapes, ray: Ray, departure: Departure, limit, kinds: Int[Array, "surfaces"], count: int
) -> tuple[Int[Array, "n"], ...]:
    """How many surfaces of each kind 0, 1, ... `count` - 1 the ray crosses before `limit`; -1 is of no kind."""
    totals = (jnp.zeros(ray.origin.shape, jnp.int32),) * count
    for first, family in shapes.numbered():
        found = family.crossing_counts(
            ray, departure.counted_from(first, shapes.sheets), limit, shapes.part(kinds, first, family), count
        )
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
    for (first, family), numbers in zip(shapes.numbered(), solids, strict=True):

        def ask(k, best, first=first, family=family, numbers=numbers):
            number = numbers[k]
            solid = jax.tree.map(lambda a: a[jnp.maximum(number - first, 0)], family)
            inner = solid.contains(point) & (but != number) & (number >= 0) & (rank[number] < best[0])
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
    distance = jnp.zeros(ray.origin.shape, ray.origin.dtype)
    found = distance, Vec3(distance, distance, distance), ray.origin, jnp.zeros(distance.shape, bool)
    for mine, member in shapes.members(primitive, lambda family: family.carrier()):
        found = where(mine, member.surface(ray, crossing), found)
    distance, outward, point, enters = found
    enters = enters if entering is None else entering
    normal = where(enters, outward, -outward)
    return Hit(primitive, shapes.object_at(primitive), crossing, enters, point, normal, normal, distance)
