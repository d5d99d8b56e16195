"""The contract of a family of surfaces: what rays ask of a shape.

What is asked of all members (the nearest, whether any blocks, ...) is one function of a member and of the answer so
far; a search asks every member, or those whose boxes a ray meets (see `_asking`).

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
from ._asking import Asked, search
from ._boxes import BoxTree, outwards
from ._footprint import LEAST_COVERAGE, Footprint
from ._ray import NOTHING, Departure, Ray


class AbstractSurfaces(eqx.Module):
    """Surfaces of one kind. A new family states `crossings` and `surface`."""

    SOLID: ClassVar[bool] = False
    """It bounds a volume, which `contains` knows."""
    FOOTPRINT: ClassVar[bool] = False
    """Its silhouette and curvature are stated, so that rays may have a footprint."""
    BOUNDED: ClassVar[bool] = False
    """Each has an end, which `boxes` knows: of many, a ray need not ask all."""

    KERNEL: ClassVar[str | None] = None
    """The kind of surface by which `_machine` knows it, where there is machine code for its search."""

    @property
    def interpolated(self) -> bool:
        """Is its shading normal another one than the geometric one?"""
        return False

    def shading(self, point: Vec3, outward: Vec3) -> tuple[Vec3, Vec3]:
        """The outward unit normal that light sees at a point, and where shadow rays leave from on the outer side."""
        return outward, point

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

    def holds(self, first, count, point: Vec3, boxes: BoxTree | None = None) -> Bool[Array, "n"]:
        """Is the point inside the object that the `count` members from `first` on make up? By default inside any."""
        del boxes

        def one(k, found):
            return found | jax.tree.map(lambda a: a[first + k], self).contains(point)

        no = jnp.zeros(point.shape, bool)
        return one(0, no) if isinstance(count, int) and count == 1 else jax.lax.fori_loop(0, count, one, no)

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

    def box(self) -> tuple[Vec3, Vec3]:
        """The least and the largest corner of a box around each surface, by default that of `bounding`; no derivatives.

        Both are moved outwards by a few roundings.
        """
        middle, radius = self.bounding()
        apart = Vec3(radius, radius, radius)
        return outwards(middle - apart, middle + apart)

    def numbers(self) -> Float[Array, "n numbers"] | None:
        """What the machine code needs to know of each surface; None where there is none."""
        return None

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
        """`carry = step(k, member, carry)` over all members: unrolled for a few, as a compiled loop for many."""

        def one(k, carry):
            return step(k, jax.tree.map(lambda a: a[k], self), carry)

        return repeated(self.count, one, carry, unrolled)

    def nearest(
        self, ray: Ray, departure: Departure, boxes: BoxTree | None = None
    ) -> tuple[Float[Array, "n"], Int[Array, "n"], Int[Array, "n"]]:
        """Distance (infinity on a miss), number and crossing of the first surface ahead."""

        def closer(asked: Asked, best, k, member):
            distance, crossing = member.first_crossing(*asked.start(k))
            return where(distance < best[0], (distance, jnp.full_like(best[1], k), crossing), best)

        missed = jnp.full(ray.origin.shape, jnp.inf, ray.origin.dtype)
        nobody = jnp.full(missed.shape, NOTHING, jnp.int32)
        best = missed, nobody, jnp.zeros(missed.shape, jnp.int8)
        return search(self, boxes, closer, Asked(ray, departure), best, lambda _, best: best[0])

    def blocked(
        self,
        ray: Ray,
        departure: Departure,
        limit,
        blocks: Sequence[bool] | Bool[Array, "members"] | None,
        boxes: BoxTree | None = None,
    ) -> Bool[Array, "n"]:
        """Does a member, of those with `blocks` where that is given, lie on the ray nearer than `limit`?"""

        def either(asked: Asked, found, k, member):
            distance, _ = member.first_crossing(*asked.start(k))
            hit = distance < asked.limit
            return found | (hit if blocks is None else hit & blocks[k])

        no = jnp.zeros(ray.origin.shape, bool)
        return search(self, boxes, either, Asked(ray, departure, limit), no, content=lambda found: found)

    def crossing_counts(
        self,
        ray: Ray,
        departure: Departure,
        limit,
        kinds: Int[Array, "members"],
        count: int,
        boxes: BoxTree | None = None,
    ) -> tuple[Int[Array, "n"], ...]:
        """How many surfaces of each kind 0 .. count - 1 the ray crosses before `limit`."""

        def counted(asked: Asked, totals, k, member):
            crossings = member.crossings(*asked.start(k))
            met = sum((distance < asked.limit).astype(jnp.int32) for distance in crossings)
            met = jnp.where(asked.departure.leaves_out(k), 0, met)
            return tuple(total + jnp.where(kinds[k] == kind, met, 0) for kind, total in enumerate(totals))

        none = (jnp.zeros(ray.origin.shape, jnp.int32),) * count
        return search(self, boxes, counted, Asked(ray, departure, limit), none)

    def near_silhouettes(
        self, ray: Ray, reach: Float[Array, "n"], growth, boxes: BoxTree | None = None
    ) -> Bool[Array, "n"]:
        """May the silhouette of some member lie within `reach` + `growth` times the distance of the ray's line?"""

        def either(asked: Asked, found, k, member):
            return found | member.near_silhouette(asked.ray, asked.reach, asked.growth)

        no = jnp.zeros(ray.origin.shape, bool)
        return search(self, boxes, either, Asked.wide(ray, reach, growth), no, content=lambda found: found)

    def nearest_part(self, ray: Ray, footprint: Footprint, departure: Departure, boxes: BoxTree | None = None):
        """The nearest member that covers part of the pixel: its distance, number, crossing, side, and whether its
        silhouette cuts the pixel. Where as many surfaces are left out already as a departure can name,
        silhouettes do not count.
        """

        def closer(asked: Asked, best, k, member):
            departure = asked.departure
            ray, on_it, inwards = asked.start(k)
            distance, crossing = member.first_crossing(ray, on_it, inwards)
            silhouette, closest = member.silhouette(ray, asked.footprint)
            missed, side = jnp.isinf(distance), member.side(ray)
            entering = member.enters(ray, crossing)
            from_outside = missed | (entering == side)
            cut = is_cut(silhouette, LEAST_COVERAGE) & from_outside & (closest > 0) & ~on_it
            cut = cut & (departure.passed[-1] == NOTHING)
            distance, entering = jnp.where(missed & cut, closest, distance), jnp.where(missed, side, entering)
            found = distance, jnp.full_like(best[1], k), crossing, entering, cut
            return where((distance < best[0]) & ~departure.leaves_out(k), found, best)

        zero = jnp.zeros(ray.origin.shape, ray.origin.dtype)
        no, nobody = jnp.zeros(zero.shape, bool), jnp.full(zero.shape, NOTHING, jnp.int32)
        best = zero + jnp.inf, nobody, jnp.zeros(zero.shape, jnp.int8), no, no
        asked = Asked.over(ray, footprint, departure, zero + jnp.inf)
        return search(self, boxes, closer, asked, best, lambda _, best: best[0], unrolled=1)

    def hidden_parts(
        self, ray: Ray, footprint: Footprint, departure: Departure, limit, blocks, found, boxes: BoxTree | None = None
    ):
        """`found` = whether the way to `limit` is blocked for the whole footprint, and the members that stand in part
        of it (-1 for a free place to name one), continued over these members. Further ones count whole or not at all.
        """

        def either(asked: Asked, found, k, member):
            whole, parts = found
            ray, on_it, inwards = asked.start(k)
            distance, crossing = member.first_crossing(ray, on_it, inwards)
            silhouette, closest = member.silhouette(ray, asked.footprint)
            from_outside = jnp.isinf(distance) | (member.enters(ray, crossing) == member.side(ray))
            free = is_cut(silhouette, LEAST_COVERAGE) & from_outside & (closest > 0) & (closest < asked.limit) & ~on_it
            cut, named = free & (parts[-1] == NOTHING), []
            for part in parts:
                take = free & (part == NOTHING)
                named.append(jnp.where(take, k, part))
                free = free & ~take
            hidden = (distance < asked.limit) & ~cut
            return whole | (hidden if blocks is None else hidden & blocks[k]), tuple(named)

        return search(self, boxes, either, Asked.over(ray, footprint, departure, limit), found, unrolled=1)

    def beside_small(self, ray: Ray, reach, growth, limit, boxes: BoxTree | None = None) -> Bool[Array, "n"]:
        """Does the ray pass, before `limit`, by a member so small that it may lie between it and the next, `reach` +
        `growth` times the distance away?
        """

        def either(asked: Asked, found, k, member):
            middle, radius = member.bounding()
            to_middle = middle - asked.ray.origin
            along = dot(to_middle, asked.ray.direction)
            miss = to_middle - asked.ray.direction * along
            apart = asked.reach + asked.growth * abs(along)
            ahead, small = (along > 0) & (along < asked.limit), radius < apart
            return found | (ahead & small & (dot(miss, miss) < (radius + apart) * (radius + apart)))

        no = jnp.zeros(ray.origin.shape, bool)
        return search(self, boxes, either, Asked.wide(ray, reach, growth, limit), no, content=lambda found: found)
