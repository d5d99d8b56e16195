"""Sides of triangles at which the outline of a mesh may run, and the search for the one in the footprint of a ray.

A side is an outline for a ray where both of its triangles lie on one side of it as seen from where the ray starts: one
is turned to the eye, the other one away. A side that belongs to one triangle only always is; one between two visible
triangles is where the surface has a crease, so that light jumps there.
"""

from collections.abc import Callable
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import Linear
from ..numerics._safe import normalise, safe_divide
from ..numerics._stage import repeated
from ..numerics._vector import Vec3, cross, dot, lookup, vec3, where
from ._asking import Asked, search
from ._boxes import BoxTree, outwards
from ._compiled import compiled_sides
from ._footprint import Footprint
from ._ray import NOTHING, Ray

BITS = 29
"""A side is known by 2**29 times its place in the triangle (0, 1, 2), plus the number of the triangle."""
LONG = 4.0
"""A crease counts where it is so many times as long as the way from the middle of the pixel to a corner."""


def side_of(triangle, place):
    """The number of a side of a triangle."""
    return triangle + (place << BITS)


def triangle_of(side):
    """The triangle of a side, and the place of the side in it; a surface that is no triangle is its own."""
    return jnp.where(side >= 0, side & ((1 << BITS) - 1), side), jnp.where(side >= 0, side >> BITS, 0)


class Sides(eqx.Module):
    """The sides of the triangles of a family, each once; no derivatives."""

    KERNEL: ClassVar[str] = "side"
    BOUNDED: ClassVar[bool] = True

    start: Vec3
    end: Vec3
    corner: Vec3
    """The third corner of its triangle."""
    beyond: Vec3
    """The third corner of the other triangle; the same again where there is none."""
    side: Int[Array, "*n"]
    """Its number (see `side_of`)."""
    other: Int[Array, "*n"]
    """The other triangle with the place of its third corner, numbered in the same way, -1 for none."""
    crease: Bool[Array, "*n"]
    """Light jumps there between the two triangles."""

    @property
    def neighbour(self) -> Int[Array, "*n"]:
        """The other triangle, -1 for none."""
        return triangle_of(self.other)[0]

    @property
    def count(self) -> int:
        return self.start.x.shape[0]

    def over(self, step: Callable, carry, unrolled: int = 1):
        """`carry = step(k, side, carry)` over all sides."""
        return repeated(self.count, lambda k, carry: step(k, lookup(self, k), carry), carry, unrolled)

    def box(self) -> tuple[Vec3, Vec3]:
        """The corners of a box around each."""
        a, b = self.start, self.end
        low, high = (Vec3(most(a.x, b.x), most(a.y, b.y), most(a.z, b.z)) for most in (jnp.minimum, jnp.maximum))
        return outwards(low, high)

    def numbers(self) -> Float[Array, "n 12"]:
        """What the machine code needs to know of each."""
        places = (self.start, self.end, self.corner, self.beyond)
        return jnp.stack([part for v in places for part in (v.x, v.y, v.z)], axis=-1)

    def flags(self) -> Int[Array, "numbers"]:
        """The same in whole numbers: both triangles, and whether it is a crease."""
        return jnp.stack([triangle_of(self.side)[0], self.neighbour, self.crease.astype(jnp.int32)], axis=-1).reshape(
            -1
        )

    def cones(self, leaf: Int[Array, "leaves"]) -> Float[Array, "numbers"]:
        """For each node of the tree with these leaves a cone around the normals on both sides of what is in it, so that
        a node whose faces all turn to the eye, or all away, need not be looked into (after Sander et al. 2000).

        Six numbers: the axis, cosine and sine of the angle to it (-1 and 0 where there is none), and whether there is a
        crease.
        """
        along = self.end - self.start
        one, other = (
            normalise(cross(along, self.corner - self.start)),
            normalise(cross(self.beyond - self.start, along)),
        )
        axis = normalise(one + other).stacked()
        angle = jnp.arccos(jnp.clip(dot(one, normalise(one + other)), -1, 1))
        angle = jnp.where(self.neighbour >= 0, angle, jnp.pi)
        there, at = leaf >= 0, jnp.maximum(leaf, 0)
        level = where(there, (angle[at], self.crease[at]), (jnp.zeros_like(angle[at]), ~there))
        axis, (angle, crease) = jnp.where(there[:, None], axis[at], 0), level
        crease, levels = crease & there, [(axis, angle, crease & there)]
        while axis.shape[0] > 1:
            # The cone around two: each axis may lie off the common one by as much as it does.
            pair = axis.reshape(-1, 2, 3)
            axis = normalise(vec3(pair.sum(axis=1))).stacked()
            off = jnp.arccos(jnp.clip((pair * axis[:, None]).sum(axis=-1), -1, 1))
            off = jnp.where((pair != 0).any(axis=-1), off, 0) + angle.reshape(-1, 2)
            angle, crease = off.max(axis=1), crease.reshape(-1, 2).any(axis=1)
            levels.append((axis, angle, crease))
        levels.append((axis * 0, angle, crease))
        axis, angle, crease = (jnp.concatenate(part[::-1]) for part in zip(*levels, strict=True))
        narrow = angle < 0.5 * jnp.pi
        cosine, sine = jnp.where(narrow, jnp.cos(angle), -1), jnp.where(narrow, jnp.sin(angle), 0)
        rows = jnp.concatenate([axis, jnp.stack([cosine, sine, crease.astype(axis.dtype)], axis=-1)], axis=1)
        return rows.reshape(-1)

    def is_outline(self, origin: Vec3) -> Bool[Array, "*n"]:
        """Seen from there, do both triangles lie on one side of it?"""
        start, end = self.start - origin, self.end - origin
        square = cross(start, end)
        one, other = dot(square, self.corner - origin), dot(square, self.beyond - origin)
        return ((one > 0) & (other > 0)) | ((one < 0) & (other < 0))

    def nearest_to(self, ray: Ray) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """How far along the ray's line it is closest to the side, and the square of how far they are apart there."""
        from_origin, along = self.start - ray.origin, self.end - self.start
        ahead, longest = dot(along, ray.direction), dot(along, along)
        square = longest - ahead * ahead
        share = ahead * dot(from_origin, ray.direction) - dot(from_origin, along)
        share = jnp.clip(share / jnp.where(square > 0, square, 1), 0, 1)
        at = from_origin + along * share
        distance = dot(at, ray.direction)
        apart = at - ray.direction * distance
        return distance, dot(apart, apart)


class Passed(eqx.Module):
    """Ends of sides that a ray runs past, so that those that go on from there are no outlines for it."""

    ends: tuple[Vec3, ...]

    def touches(self, side: Sides) -> Bool[Array, "*n"]:
        found = jnp.zeros(side.start.shape, bool)
        for end in self.ends:
            for own in (side.start, side.end):
                found = found | ((own.x == end.x) & (own.y == end.y) & (own.z == end.z))
        return found


def nearest_side(
    sides: Sides, boxes: BoxTree | None, asked: Asked, creases: bool
) -> tuple[Int[Array, "n"], Float[Array, "n"]]:
    """The number within `sides` of the outline, or crease, that passes closest to the ray's line within the footprint
    and before the limit, and its distance along the ray; -1 for none.

    Closest: by the distance across over how far the footprint reaches there; outlines come before creases.
    """

    def closer(asked: Asked, best, k, side: Sides):
        distance, apart_squared = side.nearest_to(asked.ray)
        reach = asked.reach + asked.growth * distance
        around = reach * reach
        own = asked.departure.primitive
        there = (distance > 0) & (distance < asked.limit) & (apart_squared < around)
        there = there & (own != triangle_of(side.side)[0]) & ((own != side.neighbour) | (own == NOTHING))
        outline = kind = side.is_outline(asked.ray.origin)
        if creases:
            along = side.end - side.start
            kind = kind | (side.crease & (dot(along, along) > LONG * LONG * around))
        share = apart_squared / jnp.where(around > 0, around, 1) + jnp.where(outline, 0, 1)
        there = there & kind & ~asked.extra.touches(side) & (share < best[0])
        return where(there, (share, jnp.full_like(best[1], k), distance), best)

    if boxes is not None and (found := compiled_sides(boxes, sides.flags(), asked, creases)) is not None:
        return found
    zero = jnp.zeros_like(asked.limit)
    first = zero + 2, jnp.full(zero.shape, NOTHING, jnp.int32), zero
    found = search(sides, boxes, closer, asked, first)
    return found[1], found[2]


def side_silhouette(
    start: Vec3, end: Vec3, corner: Vec3, ray: Ray, footprint: Footprint
) -> tuple[Linear, Float[Array, "*n"]]:
    """The distance of the ray's line from the line through two points, positive on the side of `corner` as seen from
    where the ray starts; and how far along the ray that is. Differentiable.

    Edge: a ray along the line has distance 0 with slope 0.
    """
    from_origin, along = start - ray.origin, end - start
    across = normalise(cross(along, ray.direction))
    ahead = dot(along, ray.direction)
    share = safe_divide(ahead * dot(from_origin, ray.direction) - dot(from_origin, along), dot(along, along) - ahead**2)
    distance = dot(from_origin + along * share, ray.direction)
    # By the plane through the eye: the triangle is seen edge-on, and the ray's own direction is another one.
    square = cross(from_origin, along)
    outer = jnp.where((dot(square, corner - start) > 0) == (dot(square, across) > 0), 1, -1)
    across = across * outer
    return Linear(
        -dot(across, from_origin), *(dot(across, step.origin + step.direction * distance) for step in footprint.sides())
    ), distance


def some_sides(sides: Sides, number: Int[Array, "n"]) -> Any:
    """Those of these numbers; some other ones for -1."""
    return lookup(sides, jnp.maximum(number, 0))
