"""The contract of a family of surfaces: what rays ask of a shape.

What is asked of all members (the nearest, whether any blocks, ...) stands in `_searches`.

A family holds all the surfaces of one kind as stacked arrays; a member of it, or for each ray the member that it met,
is the same record with the leading axis taken away or replaced by the rays. What is abstract here every family has.
The defaults mean points only: a new shape works on the day it is written, and earns its footprint later.
"""

from abc import abstractmethod
from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import Linear
from ..numerics._vector import Vec3
from ._boxes import BoxTree, outwards
from ._footprint import Footprint
from ._ray import Ray
from ._searches import AbstractSearches

Three = tuple[Vec3, Vec3, Vec3]
Shares = tuple[Float[Array, "*n"], Float[Array, "*n"], Float[Array, "*n"]]


class AbstractSurfaces(AbstractSearches):
    """Surfaces of one kind. A new family states `crossings` and `surface`."""

    SOLID: ClassVar[bool] = False
    """It bounds a volume, which `contains` knows."""
    FOOTPRINT: ClassVar[bool] = False
    """Its silhouette and curvature are stated, so that rays may have a footprint."""
    BOUNDED: ClassVar[bool] = False
    """Each has an end, which `boxes` knows: of many, a ray need not ask all."""

    DETACHED: ClassVar[bool] = False
    """Its points may lie behind what rays are tested against: all rays go on from where `shading` says."""

    SIDED: ClassVar[bool] = False
    """Its outlines run along sides that two of its members share (see `_sides`), not around each of them."""

    KERNEL: ClassVar[str | None] = None
    """The kind of surface by which `_machine` knows it, where there is machine code for its search."""

    @property
    def interpolated(self) -> bool:
        """Is its shading normal another one than the geometric one?"""
        return False

    @property
    def has_uv(self) -> bool:
        """Do its points have texture coordinates of their own, which `uv` knows?"""
        return False

    def uv(self, point: Vec3) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """Texture coordinates of a point, differentiable; 0 where it has none."""
        zero = jnp.zeros_like(point.x)
        return zero, zero

    def shading(self, ray: Ray, point: Vec3, outward: Vec3) -> tuple[Vec3, Vec3, Vec3]:
        """The outward unit normal that light sees at a point where a ray arrived, and where shadow rays leave from on
        the outer side, and on the inner side.
        """
        del ray
        return outward, point, point

    def corners_of(self, point: Vec3) -> tuple[Three, Three, Shares]:
        """Of a point where `interpolated`: places of the three corners, outward normals there, and its barycentric
        coordinates, differentiable. By default it is its own corner.
        """
        one, zero = jnp.ones_like(point.x), jnp.zeros_like(point.x)
        none = Vec3(zero, zero, zero)
        return (point, point, point), (none, none, none), (one, zero, zero)

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
