"""The contract of a family of surfaces: what rays ask of a shape.

A family holds all the surfaces of one kind as stacked arrays; a member of it, or for each ray the member that it met,
is the same record with the leading axis taken away or replaced by the rays. What is abstract here every family has.
The defaults mean points only: a new shape works on the day it is written, and earns its footprint later.
"""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import Linear, is_cut
from ..numerics._stage import UNROLLED, repeated
from ..numerics._vector import Vec3, dot, where
from ._footprint import LEAST_COVERAGE, Footprint
from ._ray import NOTHING, Departure, Ray


class AbstractSurfaces(eqx.Module):
    """Surfaces of one kind. A new family states `crossings` and `surface`."""

    SOLID: ClassVar[bool] = False
    """It bounds a volume, which `contains` knows."""
    FOOTPRINT: ClassVar[bool] = False
    """Its silhouette and curvature are stated, so that rays may have a footprint."""

    @property
    def count(self) -> int:
        """How many there are in the family."""
        return jax.tree.leaves(self)[0].shape[0]

    @property
    def crossed_at_most(self) -> int:
        """How often a line may cross all of them together."""
        return 4 * self.count

    @abstractmethod
    def crossings(
        self, ray: Ray, on_it: Bool[Array, "*n"], inwards: Bool[Array, "*n"]
    ) -> tuple[Float[Array, "*n"], ...]:
        """Distances at which the ray's line crosses the surface ahead, infinity for those that are not there.

        `on_it`: the ray starts on this very surface, on its inner side where `inwards`; the crossing where it starts
        is not ahead. The number of a crossing is its place in the tuple.
        """

    @abstractmethod
    def surface(
        self, ray: Ray, crossing: Int[Array, "*n"] | None
    ) -> tuple[Float[Array, "*n"], Vec3, Vec3, Bool[Array, "*n"]]:
        """Distance, outward unit normal and point of a crossing, differentiable in ray and surface; and whether the
        ray enters there.
        """

    def first_crossing(
        self, ray: Ray, on_it: Bool[Array, "*n"], inwards: Bool[Array, "*n"]
    ) -> tuple[Float[Array, "*n"], Int[Array, "*n"]]:
        """Distance of the nearest crossing ahead (infinity if none) and its number."""
        first, *others = self.crossings(ray, on_it, inwards)
        number = jnp.zeros(first.shape, jnp.int8)
        for k, distance in enumerate(others, 1):
            nearer = distance < first
            first, number = jnp.where(nearer, distance, first), jnp.where(nearer, jnp.int8(k), number)
        return first, number

    def enters(self, ray: Ray, crossing: Int[Array, "*n"]) -> Bool[Array, "*n"]:
        """Does the ray come from the outer side at this crossing?"""
        return self.surface(ray, crossing)[3]

    def carrier(self) -> "AbstractSurfaces":
        """The family of unbounded surfaces that carry these, whose `surface` is that of a crossing which is known to
        be inside.
        """
        return self

    def contains(self, point: Vec3) -> Bool[Array, "*n"]:
        """Is the point inside? A sheet holds no volume."""
        return jnp.zeros(point.shape, bool)

    def covers(self, point: Vec3) -> Bool[Array, "*n"]:
        """Does it reach to a point of the unbounded surface that carries it?"""
        return jnp.ones(point.shape, bool)

    def bordered(self, ray: Ray, footprint: Footprint) -> Bool[Array, "*n"]:
        """Does its border, within the unbounded surface that carries it, cut the pixel? By default it has none."""
        return jnp.zeros(ray.origin.shape, bool)

    def crossing_at(self, entering: Bool[Array, "*n"]) -> Int[Array, "*n"]:
        """The number of the crossing of a ray that is on the surface and goes through it, by the side it comes from."""
        return jnp.zeros(entering.shape, jnp.int8)

    def bounding(self) -> tuple[Vec3, Float[Array, "*n"]]:
        """Middle and radius of a sphere around each surface; infinite where none is known."""
        some = jax.tree.leaves(self)[0]
        zero = jnp.zeros(some.shape[:1], some.dtype)
        return Vec3(zero, zero, zero), jnp.full_like(zero, jnp.inf)

    def silhouette(self, ray: Ray, footprint: Footprint) -> tuple[Linear, Float[Array, "*n"]]:
        """A function over the pixel, positive where its rays meet the surface, and the distance at which the ray is
        closest to its zero. By default no silhouette ever cuts a pixel.
        """
        one = jnp.ones(ray.origin.shape, ray.origin.dtype)
        zero = jnp.zeros_like(one)
        return Linear(one, zero, zero), zero

    def near_silhouette(self, ray: Ray, reach: Float[Array, "*n"], growth) -> Bool[Array, "*n"]:
        """May the silhouette lie within `reach` + `growth` times the distance of the ray's line?"""
        return jnp.zeros(ray.origin.shape, bool)

    def side(self, ray: Ray) -> Bool[Array, "*n"]:
        """Does a ray that only just meets the surface come from its outer side?"""
        return jnp.ones(ray.origin.shape, bool)

    def curvature(self) -> Float[Array, "*n"]:
        """The outward unit normal changes by this times a small step along the surface."""
        return jnp.zeros_like(jax.tree.leaves(self)[0])

    def over(self, step: Callable, carry, unrolled: int = UNROLLED):
        """`carry = step(number, member, carry)` over all members: unrolled for a few, as a compiled loop for many."""

        def one(k, carry):
            return step(k, jax.tree.map(lambda a: a[k], self), carry)

        return repeated(self.count, one, carry, unrolled)

    def nearest(self, ray: Ray, departure: Departure) -> tuple[Float[Array, "n"], Int[Array, "n"], Int[Array, "n"]]:
        """Distance (infinity on a miss), number and crossing of the first surface ahead. The default asks every
        member.
        """

        def closer(k, member, best):
            distance, crossing = member.first_crossing(ray, departure.starts_on(k), departure.inwards)
            return where(distance < best[0], (distance, jnp.full_like(best[1], k), crossing), best)

        missed = jnp.full(ray.origin.shape, jnp.inf, ray.origin.dtype)
        nobody = jnp.full(missed.shape, NOTHING, jnp.int32)
        return self.over(closer, (missed, nobody, jnp.zeros(missed.shape, jnp.int8)))

    def blocked(
        self, ray: Ray, departure: Departure, limit, blocks: Sequence[bool] | Bool[Array, "members"] | None
    ) -> Bool[Array, "n"]:
        """Does a member, of those with `blocks` where that is given, lie on the ray nearer than `limit`?"""

        def either(k, member, found):
            distance, _ = member.first_crossing(ray, departure.starts_on(k), departure.inwards)
            hit = distance < limit
            return found | (hit if blocks is None else hit & blocks[k])

        return self.over(either, jnp.zeros(ray.origin.shape, bool))

    def crossing_counts(
        self, ray: Ray, departure: Departure, limit, kinds: Int[Array, "members"], count: int
    ) -> tuple[Int[Array, "n"], ...]:
        """How many surfaces of each kind 0 .. count - 1 the ray crosses before `limit`."""

        def counted(k, member, totals):
            crossings = member.crossings(ray, departure.starts_on(k), departure.inwards)
            met = sum((distance < limit).astype(jnp.int32) for distance in crossings)
            met = jnp.where(departure.leaves_out(k), 0, met)
            return tuple(total + jnp.where(kinds[k] == kind, met, 0) for kind, total in enumerate(totals))

        return self.over(counted, (jnp.zeros(ray.origin.shape, jnp.int32),) * count)

    def near_silhouettes(self, ray: Ray, reach: Float[Array, "n"], growth) -> Bool[Array, "n"]:
        """May the silhouette of some member lie within `reach` + `growth` times the distance of the ray's line?"""

        def either(k, member, found):
            return found | member.near_silhouette(ray, reach, growth)

        return self.over(either, jnp.zeros(ray.origin.shape, bool))

    def nearest_part(self, ray: Ray, footprint: Footprint, departure: Departure):
        """The nearest member that covers part of the pixel: its distance, number, crossing, side, and whether its
        silhouette cuts the pixel. Where as many surfaces are left out already as a departure can name,
        silhouettes do not count.
        """
        may_pass = departure.passed[-1] == NOTHING

        def closer(k, member, best):
            on_it = departure.starts_on(k)
            distance, crossing = member.first_crossing(ray, on_it, departure.inwards)
            silhouette, closest = member.silhouette(ray, footprint)
            missed, side = jnp.isinf(distance), member.side(ray)
            entering = member.enters(ray, crossing)
            from_outside = missed | (entering == side)
            cut = is_cut(silhouette, LEAST_COVERAGE) & from_outside & (closest > 0) & ~on_it & may_pass
            distance, entering = jnp.where(missed & cut, closest, distance), jnp.where(missed, side, entering)
            found = distance, jnp.full_like(best[1], k), crossing, entering, cut
            return where((distance < best[0]) & ~departure.leaves_out(k), found, best)

        zero = jnp.zeros(ray.origin.shape, ray.origin.dtype)
        no, nobody = jnp.zeros(zero.shape, bool), jnp.full(zero.shape, NOTHING, jnp.int32)
        return self.over(closer, (zero + jnp.inf, nobody, jnp.zeros(zero.shape, jnp.int8), no, no), unrolled=1)

    def hidden_parts(self, ray: Ray, footprint: Footprint, departure: Departure, limit, blocks, found):
        """`found` = whether the way to `limit` is blocked for the whole footprint, and the members that stand in part
        of it (-1 for a free place to name one), continued over these members. Further ones count whole or not at all.
        """

        def either(k, member, found):
            whole, parts = found
            on_it = departure.starts_on(k)
            distance, crossing = member.first_crossing(ray, on_it, departure.inwards)
            silhouette, closest = member.silhouette(ray, footprint)
            from_outside = jnp.isinf(distance) | (member.enters(ray, crossing) == member.side(ray))
            free = is_cut(silhouette, LEAST_COVERAGE) & from_outside & (closest > 0) & (closest < limit) & ~on_it
            cut, named = free & (parts[-1] == NOTHING), []
            for part in parts:
                take = free & (part == NOTHING)
                named.append(jnp.where(take, k, part))
                free = free & ~take
            hidden = (distance < limit) & ~cut
            return whole | (hidden if blocks is None else hidden & blocks[k]), tuple(named)

        return self.over(either, found, unrolled=1)

    def beside_small(self, ray: Ray, reach, growth, limit) -> Bool[Array, "n"]:
        """Does the ray pass, before `limit`, by a member so small that it may lie between it and the next, `reach` +
        `growth` times the distance away?
        """

        def either(k, member, found):
            middle, radius = member.bounding()
            to_middle = middle - ray.origin
            along = dot(to_middle, ray.direction)
            miss = to_middle - ray.direction * along
            apart = reach + growth * abs(along)
            ahead, small = (along > 0) & (along < limit), radius < apart
            return found | (ahead & small & (dot(miss, miss) < (radius + apart) * (radius + apart)))

        return self.over(either, jnp.zeros(ray.origin.shape, bool))
