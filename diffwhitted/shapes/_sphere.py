"""Spheres."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import AbstractSurfaces, Footprint, Ray
from ..numerics._coverage import Linear
from ..numerics._safe import length, normalise, safe_divide, safe_sqrt
from ..numerics._vector import Vec3, dot, vec3, where
from ..records import Row, read_rows
from ._object import AbstractObject


class Spheres(AbstractSurfaces):
    """Spheres by centre and radius (arrays over the spheres, or over rays after a look-up)."""

    SOLID: ClassVar[bool] = True
    FOOTPRINT: ClassVar[bool] = True
    BOUNDED: ClassVar[bool] = True
    KERNEL: ClassVar[str | None] = "sphere"

    centre: Vec3
    radius: Float[Array, "*n"]

    def crossings(self, ray: Ray, on_it, inwards):
        """Distances of the crossings ahead, in order; infinity where there is none.

        Hearn and Baker (14-58): s = u.dP -+ sqrt(r**2 - |dP - (u.dP) u|**2), the form that survives a
        radius much smaller than the distance |dP|.
        """
        middle, _, half_chord_squared = self._chord(ray)
        half_chord = jnp.sqrt(jnp.maximum(half_chord_squared, 0))
        met = half_chord_squared > 0
        near, far = middle - half_chord, middle + half_chord
        near = jnp.where(met & (near > 0) & ~on_it, near, jnp.inf)
        far = jnp.where(met & (far > 0) & (~on_it | inwards), far, jnp.inf)
        return near, far

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point of the recorded crossing, differentiable; a ray enters at the
        nearer one.

        The normal comes from the offset (dP - (u.dP) u) and the half chord, and for a far or small
        sphere the point comes from centre and normal: both keep their digits where `ray.at(distance)`
        has lost them to the distance. Edge: on the silhouette, where the half chord vanishes, its
        derivative is 0 by `safe_sqrt`.
        """
        middle, miss, half_chord_squared = self._chord(ray)
        half_chord = safe_sqrt(half_chord_squared)
        entering = crossing == 0
        half_chord = jnp.where(entering, -half_chord, half_chord)
        distance = middle + half_chord
        outward = (ray.direction * half_chord - miss) * safe_divide(1, self.radius)
        point = where(self.radius < distance, self.centre + outward * self.radius, ray.at(distance))
        return distance, outward, point, entering

    def silhouette(self, ray: Ray, footprint: Footprint):
        """r - |q| with q from the ray's line to the centre: positive where the line meets the sphere; and where it is
        closest.
        """
        middle, miss, _ = self._chord(ray)
        sideways = normalise(miss)

        def along(side: Ray):
            return dot(sideways, side.origin + side.direction * middle)

        return Linear(self.radius - length(miss), along(footprint.across), along(footprint.down)), middle

    def near_silhouette(self, ray: Ray, reach, growth):
        """May the silhouette lie within `reach` + `growth` times the distance of the ray's line? No derivatives."""
        middle, miss, _ = self._chord(ray)
        around = reach + growth * abs(middle)
        low, high = jnp.maximum(self.radius - around, 0), self.radius + around
        from_line = dot(miss, miss)
        return (from_line >= low * low) & (from_line <= high * high)

    def side(self, ray: Ray):
        """Does a ray that only just meets the shape come from its outer side?"""
        return jnp.ones(ray.origin.shape, bool)

    def curvature(self):
        """The outward unit normal changes by this times a small step along the surface."""
        return safe_divide(1, self.radius)

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        return self.centre, self.radius

    def numbers(self):
        return jnp.stack([self.centre.x, self.centre.y, self.centre.z, self.radius], axis=-1)

    def crossing_at(self, entering):
        """A ray enters at the nearer of the two."""
        return jnp.where(entering, 0, 1).astype(jnp.int8)

    def contains(self, point: Vec3):
        offset = point - self.centre
        return dot(offset, offset) < self.radius * self.radius

    def _chord(self, ray: Ray):
        """The distance at which the ray's line is closest to the centre, the way from there to the centre, and the
        square of half the chord that the sphere cuts out of the line (negative where it misses).
        """
        to_centre = self.centre - ray.origin
        middle = dot(to_centre, ray.direction)
        miss = to_centre - ray.direction * middle
        return middle, miss, self.radius * self.radius - dot(miss, miss)


class Sphere(AbstractObject):
    """A sphere: centre and radius in metres."""

    TYPE: ClassVar[str] = "sphere"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("centre", "vector", "Centre, metres.", unit="m", scale="unbounded", moves="rays"),
        Row("radius", "number", "Radius, metres.", unit="m", lowest=0, excluded=True, scale="log", moves="rays",
            below="For a bubble or a hollow ball put a sphere of refractive_index 1 inside the glass"),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Spheres
    CONVEX: ClassVar[bool] = True
    ROUND: ClassVar[bool] = True

    centre: Float[Array, "3"]
    radius: Float[Array, ""]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, centre, radius, material: str, place: str | None = None):
        self.name, self.material = name, material
        read_rows(self, place or f"object {name!r}", centre=centre, radius=radius)

    @classmethod
    def family(cls, centre, radius) -> Spheres:
        return Spheres(vec3(centre), radius)

    def size(self) -> Float[Array, ""]:
        return self.radius

    def away_from(self, place: np.ndarray) -> float:
        middle, radius = self.ball()
        return abs(float(np.linalg.norm(middle - place)) - radius)

    def ball(self) -> tuple[np.ndarray, float]:
        return np.asarray(self.centre, np.float64), float(self.radius)
