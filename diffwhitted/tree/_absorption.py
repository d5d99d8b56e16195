"""What is left of light after its way through absorbing glass: exp(-extinction d) on d metres (Parker et al. 3.1)."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..geometry import NOTHING, Asked, Departure, Ray, containing, search
from ..illumination import before
from ..numerics._stage import stage
from ..numerics._vector import Vec3, lookup
from ..scene import AbstractLight, Tables
from ._arrival import TRANSMITTED, Arrival, Origin
from ._departure import of_camera
from ._made_of import material_at, sides
from ._plan import Plan

Inside = tuple[tuple[Float[Array, "n"], ...], tuple[Int[Array, "n"], ...]]
"""For each transparent material: the metres on the way that lie in it, and whether the way is in it at its end."""


def left_after(tables: Tables, plan: Plan, parents: Arrival | None, origin: Origin, at: Arrival) -> Vec3:
    """The share of light that is left after the way of the rays of a block, linear RGB.

    Edge: a ray that meets nothing within an absorbing medium brings nothing, with derivative 0.
    """
    here = sides(at)[0]
    medium = here
    if plan.branching:

        def sent_on(parents):
            here, beyond = sides(parents)
            return jnp.where(origin.branch == TRANSMITTED, beyond, here)

        medium = jax.lax.cond(of_camera(origin), lambda parents: here, sent_on, parents)
    extinction = lookup(tables.coefficients["extinction"], material_at(tables, jnp.maximum(medium, 0)))
    inside, missed = medium >= 0, at.object < 0
    return _channels(extinction, lambda a: _left(jnp.where(inside, a, 0), at.distance, inside & missed))


def left_on_the_way_to(tables: Tables, plan: Plan, at: Arrival, light: AbstractLight, needed) -> Vec3:
    """The share of a light that is left of it after its way to the points through absorbing glass, linear RGB.

    Differentiable in extinction and, but for families that are searched by a tree, in geometry.
    """
    origin, departure = at.lit_from
    lengths, inside, limit = stage(needed, lambda *a: _inside(tables, plan, at, light, *a), origin, departure)
    left = None
    for material, length, within in zip(tables.marks.glass, lengths, inside, strict=True):
        column = tables.coefficients["extinction"]
        extinction = jax.tree.map(lambda c, m=material: c[jnp.maximum(m, 0)], column)
        endless = (within > 0) & jnp.isinf(limit)
        metres = length + jnp.where((within > 0) & ~endless, jnp.where(endless, 0, limit), 0)
        part = _channels(extinction, lambda a, d=metres, e=endless: _left(a, d, e))
        left = part if left is None else left * part
    return left


def _left(extinction, metres: Float[Array, "n"], endless: Bool[Array, "n"]) -> Float[Array, "n"]:
    """exp(-a d) of one channel; 0 after a way without end, where there is any extinction."""
    return jnp.where(endless & (extinction > 0), 0, jnp.exp(-extinction * jnp.where(endless, 0, metres)))


def _channels(colour: Vec3, of) -> Vec3:
    return Vec3(of(colour.x), of(colour.y), of(colour.z))


def _inside(tables: Tables, plan: Plan, at: Arrival, light: AbstractLight, origin: Vec3, departure: Departure):
    """Where the way from the points to a light lies in which transparent material, and how long it is.

    At each crossing the medium changes: d metres before it count for the one that ends there, and are taken off the one
    that begins.
    """
    to_light, distance, _ = light.arriving(origin)
    ray, limit, count = Ray(origin, to_light), before(distance), tables.marks.glass.shape[0]
    start = _kind_of(tables, sides(at)[0])
    zero = jnp.zeros_like(origin.x)
    found: Inside = (zero,) * count, tuple((start == kind).astype(jnp.int32) for kind in range(count))
    for first, family, boxes in tables.shapes.searched():
        leaves = departure.counted_from(first, tables.shapes.sheets)
        numbered = _Numbered(tables, plan, first)
        if boxes is None:
            asked = Asked(ray, leaves, limit)
            found = family.over(lambda k, member, found, by=numbered, a=asked: by.crossed(a, found, k, member), found)
        else:
            # What a walk over a tree finds has no derivative.
            still = jax.lax.stop_gradient((family, Asked(ray, leaves, limit), found))
            lengths, within = search(still[0], boxes, numbered.crossed, still[1], ((zero,) * count, found[1]))
            found = tuple(a + b for a, b in zip(found[0], lengths, strict=True)), within
    return *found, distance


class _Numbered:
    """Crossings of surfaces whose numbers begin with `first`."""

    def __init__(self, tables: Tables, plan: Plan, first: int):
        self.tables, self.plan, self.first = tables, plan, first

    def crossed(self, asked: Asked, found: Inside, k, member) -> Inside:
        """What the crossings of one member add."""
        tables, (ray, on_it, inwards) = self.tables, asked.start(k)
        object = tables.shapes.object_at(jnp.full(ray.origin.shape, k + self.first, jnp.int32))
        for number, ahead in enumerate(member.crossings(ray, on_it, inwards)):
            met = jax.lax.stop_gradient(ahead) < jax.lax.stop_gradient(asked.limit)
            distance, _, point, entering = member.surface(ray, jnp.full(met.shape, number, jnp.int8))
            outside = self._around(point, object)
            ends = _kind_of(tables, jnp.where(entering, outside, object))
            begins = _kind_of(tables, jnp.where(entering, object, outside))
            found = _changed(found, met, jnp.where(met, distance, 0), ends, begins)
        return found

    def _around(self, point: Vec3, object: Int[Array, "n"]) -> Int[Array, "n"]:
        """The solid around an object at a point, -1 for none."""
        if not self.plan.effects.nested_media:
            return jnp.full_like(object, NOTHING)
        tables, point = self.tables, jax.lax.stop_gradient(point)
        clear = lookup(tables.clear, tables.material_of)
        return containing(tables.shapes, point, tables.marks.solids, tables.rank, object, lambda number: clear[number])


def _changed(found: Inside, met, distance, ends: Int[Array, "n"], begins: Int[Array, "n"]) -> Inside:
    lengths, within = found
    longer, deeper = [], []
    for kind, (length, inside) in enumerate(zip(lengths, within, strict=True)):
        change = jnp.where(met, (begins == kind).astype(jnp.int32) - (ends == kind), 0)
        longer.append(length - distance * change)
        deeper.append(inside + change)
    return tuple(longer), tuple(deeper)


def _kind_of(tables: Tables, object: Int[Array, "n"]) -> Int[Array, "n"]:
    """The place of the material of each object among the transparent ones; -1 for none, and for -1."""
    surface = tables.shapes.first_surface(object)
    return jnp.where(object >= 0, lookup(tables.glass_of, jnp.maximum(surface, 0)), NOTHING)
