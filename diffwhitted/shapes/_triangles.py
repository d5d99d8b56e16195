"""Triangles: the surfaces that meshes consist of."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..geometry import (
    BITS,
    AbstractSurfaces,
    Asked,
    BoxTree,
    Departure,
    Footprint,
    Ray,
    Sides,
    Three,
    free,
    outwards,
    search,
    searcher,
    side_silhouette,
)
from ..numerics._safe import normalise, power_of_two, safe_divide
from ..numerics._vector import Vec3, cross, dot, lookup, where

CREASE = 0.9998
"""Cosine of the angle between normals at which light is seen to jump, 1.1 degrees."""
NUMBER = (1 << BITS) - 1
SKEW = (0.5773, 0.5271, 0.6238)
"""A direction along which no side of a mesh is likely to run."""


class Triangles(AbstractSurfaces):
    """Triangles by their corners, counter-clockwise seen from outside, and what is interpolated between these."""

    BOUNDED: ClassVar[bool] = True
    FOOTPRINT: ClassVar[bool] = True
    SIDED: ClassVar[bool] = True
    KERNEL: ClassVar[str | None] = "triangle"

    corners: tuple[Vec3, Vec3, Vec3]
    normals: tuple[Vec3, Vec3, Vec3] | None = None
    """Unit normals at the corners; None where all are flat."""
    uvs: tuple[tuple[Float[Array, "*n"], Float[Array, "*n"]], ...] | None = None
    """Texture coordinates of the corners."""

    @property
    def has_uv(self) -> bool:
        return self.uvs is not None

    @property
    def interpolated(self) -> bool:
        return self.normals is not None

    def crossings(self, ray: Ray, on_it, inwards):
        """Distance of the crossing ahead (infinity if none), as a tuple of one.

        After Woop, Benthin and Wald 2013: the ray runs along the last axis of a sheared system, where each side is
        asked on which side of it the origin lies. Each side is computed from the same one of its ends in both triangles
        that share it, so that no ray falls between them, whatever the compiler makes of a product and a sum.
        """
        del inwards
        direction, origin = ray.direction, ray.origin
        x, y, z = abs(direction.x), abs(direction.y), abs(direction.z)
        along_x, along_y = (x > y) & (x > z), ~((x > y) & (x > z)) & (y > z)

        def turned(v: Vec3) -> Vec3:
            return where(along_x, Vec3(v.y, v.z, v.x), where(along_y, Vec3(v.z, v.x, v.y), v))

        d = turned(direction)
        slope = 1 / jnp.where(d.z == 0, 1, d.z)
        shear_x, shear_y = d.x * slope, d.y * slope
        flat = []
        for corner in self.corners:
            away = turned(corner - origin)
            flat.append((away.x - shear_x * away.z, away.y - shear_y * away.z, away.z))
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = flat
        u, v, w = _side(cx, cy, bx, by), _side(ax, ay, cx, cy), _side(bx, by, ax, ay)
        area = u + v + w
        inside = ((u >= 0) & (v >= 0) & (w >= 0)) | ((u <= 0) & (v <= 0) & (w <= 0))
        met = inside & (area != 0) & ~on_it
        distance = (u * az + v * bz + w * cz) * slope / jnp.where(met, area, 1)
        return (jnp.where(met & (distance > 0), distance, jnp.inf),)

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point, differentiable. Edge: a parallel ray gives distance 0."""
        del crossing
        normal = self.normal()
        towards = dot(normal, ray.direction)
        distance = safe_divide(dot(normal, self.corners[0] - ray.origin), towards)
        return distance, normal, ray.at(distance), towards < 0

    def normal(self) -> Vec3:
        """The outward unit normal of the plane."""
        one, other = self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]
        # Only the direction is wanted: the square of an area would leave the range of numbers.
        largest = jax.lax.stop_gradient(
            jnp.maximum(*(jnp.maximum(jnp.maximum(abs(v.x), abs(v.y)), abs(v.z)) for v in (one, other)))
        )
        scale = power_of_two(largest)
        return normalise(cross(one * scale, other * scale))

    def shares(self, point: Vec3) -> tuple[Float[Array, "*n"], ...]:
        """The barycentric coordinates of a point of the plane, differentiable."""
        a, b, c = self.corners
        normal = self.normal()
        parts = [dot(normal, cross(p - point, q - point)) for p, q in ((b, c), (c, a), (a, b))]
        whole = parts[0] + parts[1] + parts[2]
        return tuple(safe_divide(part, whole) for part in parts)

    def shading(self, ray: Ray, point: Vec3, outward: Vec3) -> tuple[Vec3, Vec3, Vec3]:
        """The outward normal that light sees, between those of the corners (Phong; Hearn and Baker 14-42), and a point
        above the triangle from which shadow rays leave.

        That point lies on the smooth surface that the normals suggest, so that no triangle stands in its own light
        (Hanika 2021, "Hacking the Shadow Terminator"): between the feet of the point on the planes of the corners.
        """
        del ray
        if self.normals is None:
            return outward, point, point
        shares = self.shares(point)
        normal, lifted = outward * 0, outward * 0
        for share, corner, one in zip(shares, self.corners, self.normals, strict=True):
            normal = normal + one * share
            below = jnp.minimum(dot(point - corner, one), 0)
            lifted = lifted + (point - one * below) * share
        return normalise(normal), lifted, point

    def corners_of(self, point: Vec3):
        assert self.normals is not None
        return self.corners, self.normals, self.shares(point)

    def uv(self, point: Vec3) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """Texture coordinates of a point, between those of the corners, differentiable."""
        zero = jnp.zeros_like(point.x)
        u, v = zero, zero
        for share, (one, other) in zip(self.shares(point), self.uvs or (), strict=self.uvs is not None):
            u, v = u + share * one, v + share * other
        return u, v

    def holds(self, first, count, point: Vec3, boxes: BoxTree | None = None) -> Bool[Array, "n"]:
        """Is the point inside a closed mesh: does a ray from it cross the triangles of the mesh an odd number of
        times?
        """
        one = jnp.ones_like(point.x)
        ray = Ray(point, Vec3(*(one * part for part in SKEW)))

        def crossed(asked: Asked, odd, k, member):
            (distance,) = member.crossings(*asked.start(k))
            return odd ^ (jnp.isfinite(distance) & (k >= first) & (k < first + count))

        return search(self, boxes, crossed, Asked(ray, free(point.shape)), one < 0)

    def nearest_part(self, ray: Ray, footprint: Footprint, departure: Departure, boxes: BoxTree | None = None):
        """The nearest, by its own search: none has a silhouette of its own (see `SIDED`)."""
        del footprint
        by = self if boxes is None or departure.sheet is not None else searcher(self, boxes, None)
        distance, number, crossing = by.nearest(ray, departure, boxes)
        entering = lookup(self, jnp.maximum(number, 0)).enters(ray, crossing)
        return distance, number, crossing, entering, jnp.zeros_like(entering)

    def near_silhouettes(self, ray: Ray, reach, growth, boxes: BoxTree | None = None):
        return jnp.zeros(ray.origin.shape, bool)

    def hidden_parts(
        self, ray: Ray, footprint: Footprint, departure: Departure, limit, blocks, found, boxes: BoxTree | None = None
    ):
        """Whole, or not at all."""
        by = self if boxes is None or departure.sheet is not None else searcher(self, boxes, None)
        return found[0] | by.blocked(ray, departure, limit, blocks, boxes), found[1]

    def side(self, place) -> Three:
        """Both ends of a side by its place (0: from the first corner to the second one), and the third corner."""
        a, b, c = self.corners
        return where(place == 0, (a, b, c), where(place == 1, (b, c, a), (c, a, b)))

    def outline(self, place, ray: Ray, footprint: Footprint):
        """The silhouette of the mesh along a side, positive where the triangle is, and its distance (see `_sides`)."""
        return side_silhouette(*self.side(place), ray, footprint)

    def curvature(self):
        """How the normals at the corners turn from one to the other, in the mean over the sides; 0 where flat."""
        if self.normals is None:
            return jnp.zeros_like(self.corners[0].x)
        total = jnp.zeros_like(self.corners[0].x)
        for k in range(3):
            step = self.corners[k] - self.corners[k - 1]
            total = total + safe_divide(dot(self.normals[k] - self.normals[k - 1], step), dot(step, step))
        return total * (1 / 3)

    def sides(self, side, other) -> Sides:
        """The sides of these triangles by number (see `side_of`), with the triangle on the other side of each, known by
        the place of its third corner in it in the same way, -1 for none. No derivatives.
        """
        mesh = jax.lax.stop_gradient(self)
        mine, there = lookup(mesh, side & NUMBER), other >= 0
        beyond = jnp.where(there, other, side)
        their = lookup(mesh, beyond & NUMBER)
        start, end, corner = mine.side(side >> BITS)
        third, _, _ = their.side(beyond >> BITS)
        return Sides(
            start, end, corner, where(there, third, corner), side, other,
            there & mine.creased(side >> BITS, their, beyond >> BITS),
        )  # fmt: skip

    def creased(self, place, other: "Triangles", corner):
        """Do the normals of two triangles differ where they meet: along the side at `place`, opposite of the `corner`
        of the other one?
        """
        if self.normals is None or other.normals is None:
            return dot(self.normal(), other.normal()) < CREASE
        start, end, _ = Triangles(self.normals).side(place)
        _, first, last = Triangles(other.normals).side(corner)
        return (dot(start, last) < CREASE) | (dot(end, first) < CREASE)

    def box(self):
        a, b, c = self.corners
        low, high = (
            Vec3(*(most(most(p, q), r) for p, q, r in zip(*map(_parts, (a, b, c)), strict=True)))
            for most in (jnp.minimum, jnp.maximum)
        )
        return outwards(low, high)

    def bounding(self):
        """Middle and radius of a sphere around each."""
        low, high = self.box()
        half = (high - low) * 0.5
        return low + half, jnp.sqrt(dot(half, half))

    def numbers(self):
        return jnp.stack([part for corner in self.corners for part in _parts(corner)], axis=-1)


def _parts(v: Vec3):
    return v.x, v.y, v.z


def _side(px, py, qx, qy):
    """Twice the signed area of the origin and the two ends of a side, from the lower end on."""
    swapped = (px > qx) | ((px == qx) & (py > qy))
    (px, py), (qx, qy) = where(swapped, ((qx, qy), (px, py)), ((px, py), (qx, qy)))
    area = px * qy - py * qx
    return jnp.where(swapped, -area, area)
