"""All surfaces of a scene under one numbering, and the searches over them.

The numbering runs through the families in the order of the fields below. A family is a record with
`crossings`, `first_crossing`, `carrier`, `surface` and `contains`; a new shape is a file with such a record and
one more field here.
"""

from collections.abc import Iterator

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._vector import Vec3, dot, lookup, where
from ._hit import Hit
from ._ray import NOTHING, Departure, Ray
from .shapes._plane import Planes
from .shapes._polygon import Polygons
from .shapes._sphere import Spheres

UNROLLED = 8


class Shapes(eqx.Module):
    """The families of surfaces in a scene; a family that the scene does not use is None."""

    spheres: Spheres | None = None
    planes: Planes | None = None
    polygons: Polygons | None = None

    def families(self) -> Iterator[tuple[int, int, Spheres | Planes | Polygons]]:
        """(first index, count, family) for each family that is there."""
        first = 0
        for family in (self.spheres, self.planes, self.polygons):
            if family is not None:
                count = jax.tree.leaves(family)[0].shape[0]
                yield first, count, family
                first += count


def nearest(
    shapes: Shapes, ray: Ray, departure: Departure
) -> tuple[Float[Array, "n"], Int[Array, "n"], Bool[Array, "n"]]:
    """Distance (infinity on a miss), object (-1 on a miss) and side of the first surface ahead."""

    def closer(best, index, shape):
        distance, entering = shape.first_crossing(ray, departure.object == index, departure.inwards)
        return where(distance < best[0], (distance, jnp.full_like(best[1], index), entering), best)

    missed = jnp.full(ray.origin.shape, jnp.inf, ray.origin.dtype)
    start = (missed, jnp.full(missed.shape, NOTHING, jnp.int32), jnp.zeros(missed.shape, bool))
    return fold(shapes, closer, start)


def blocked(shapes: Shapes, ray: Ray, departure: Departure, limit, blocks: tuple[bool, ...]) -> Bool[Array, "n"]:
    """Does a surface with `blocks[object]` lie on the ray nearer than `limit`?"""

    def either(found, index, shape):
        distance, _ = shape.first_crossing(ray, departure.object == index, departure.inwards)
        return found | (distance < limit)

    return fold(shapes, either, jnp.zeros(ray.origin.shape, bool), only=blocks)


def crossing_count(shapes: Shapes, ray: Ray, departure: Departure, limit, counted: tuple[bool, ...]) -> Int[Array, "n"]:
    """How many surfaces of the objects with `counted[object]` the ray crosses before `limit`."""

    def count(total, index, shape):
        crossings = shape.crossings(ray, departure.object == index, departure.inwards)
        counts = ~departure.leaves_out(index)
        return total + sum((counts & (distance < limit)).astype(jnp.int32) for distance in crossings)

    return fold(shapes, count, jnp.zeros(ray.origin.shape, jnp.int32), only=counted)


def containing(shapes: Shapes, point: Vec3, solids: tuple[int, ...], but: Int[Array, "n"]) -> Int[Array, "n"]:
    """The first of `solids` that holds the point, leaving out the one named in `but`; -1 if none does.

    `solids` is in order of priority. With the smallest first this is the innermost of nested solids.
    """
    innermost = jnp.full(point.shape, NOTHING, jnp.int32)
    for index in reversed(solids):
        for first, count, family in shapes.families():
            if first <= index < first + count:
                shape = jax.tree.map(lambda a: a[index - first], family)  # noqa: B023
                innermost = jnp.where(shape.contains(point) & (but != index), index, innermost)
    return innermost


def surface_at(shapes: Shapes, ray: Ray, object: Int[Array, "n"], entering: Bool[Array, "n"]) -> Hit:
    """The hit on a known object from a known side, differentiable in the ray and the shape.

    A miss (object -1) gets distance 0 and a zero normal, so that nothing infinite enters a derivative.
    """
    distance = jnp.zeros(ray.origin.shape, ray.origin.dtype)
    outward = Vec3(distance, distance, distance)
    point = ray.origin
    for first, count, family in shapes.families():
        mine = (object >= first) & (object < first + count)
        found = lookup(family.carrier(), jnp.where(mine, object - first, 0)).surface(ray, entering)
        distance, outward, point = where(mine, found, (distance, outward, point))
    normal = where(entering, outward, -outward)
    return Hit(object, entering, point, normal, distance)


def facing(hit: Hit, direction: Vec3) -> Float[Array, "n"]:
    """Cosine between the facing normal and the way back along the incoming direction."""
    return -dot(hit.normal, direction)


def fold(shapes: Shapes, step, carry, only: tuple[bool, ...] | None = None, unrolled: int = UNROLLED):
    """Carry a result over all objects: unrolled for a few, as a compiled loop for many."""
    for first, count, family in shapes.families():
        wanted = [i for i in range(count) if only is None or only[first + i]]
        if len(wanted) <= unrolled:
            for i in wanted:
                carry = step(carry, first + i, jax.tree.map(lambda a: a[i], family))  # noqa: B023
        else:
            members = jnp.asarray(wanted, jnp.int32)

            def body(k, carry, first=first, family=family, members=members):
                i = members[k]
                return step(carry, first + i, jax.tree.map(lambda a: a[i], family))

            carry = jax.lax.fori_loop(0, len(wanted), body, carry)
    return carry
