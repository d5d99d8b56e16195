"""What rays ask of all surfaces of a family: each question a fold over its members (see `_asking`)."""

from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import is_cut
from ..numerics._stage import UNROLLED, repeated
from ..numerics._vector import dot, where
from ._asking import Asked, search
from ._boxes import BoxTree
from ._footprint import LEAST_COVERAGE, Footprint
from ._ray import NOTHING, Departure, Ray


class AbstractSearches(eqx.Module):
    """The questions; a family that owns another search states them anew. The members answer as `AbstractSurfaces`."""

    @property
    def count(self) -> int:
        """How many there are in the family."""
        return jax.tree.leaves(self)[0].shape[0]

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
