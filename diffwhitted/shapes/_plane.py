"""Infinite planes, each the boundary of the half space that its normal points away from."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import AbstractSurfaces, Footprint, Ray
from ..numerics._coverage import Linear
from ..numerics._safe import length, normalise, rescaled, safe_divide
from ..numerics._vector import Vec3, dot, vec3
from ..records import Row, changed, is_traced, read_rows, shifted
from ._object import AbstractObject

HORIZON = 1e30
"""Metres; how far away a ray that runs along a plane is taken to come near it."""


class Planes(AbstractSurfaces):
    """Planes normal.x = offset with unit normals (arrays over the planes, or over rays)."""

    SOLID: ClassVar[bool] = True
    FOOTPRINT: ClassVar[bool] = True

    normal: Vec3
    offset: Float[Array, "*n"]

    def crossings(self, ray: Ray, on_it, inwards):
        """Distance of the crossing ahead (infinity if none), as a tuple of one.

        Hearn and Baker (14-62): s = -(D + N.P0) / (N.u), here with D = -offset.
        """
        del inwards
        distance, _ = self._crossing(ray)
        return (jnp.where((distance > 0) & ~on_it, distance, jnp.inf),)

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point, differentiable. Edge: a parallel ray gives distance 0."""
        del crossing
        distance, entering = self._crossing(ray)
        return distance, self.normal, ray.at(distance), entering

    def silhouette(self, ray: Ray, footprint: Footprint):
        """N.u, positive where the ray heads for the plane: the horizon, further away than anything else."""
        sign = jnp.where(self.side(ray), -1, 1).astype(ray.origin.dtype)
        rise = Linear(
            *(sign * dot(self.normal, d) for d in (ray.direction, footprint.across.direction, footprint.down.direction))
        )
        return rise, jnp.full_like(sign, HORIZON)

    def near_silhouette(self, ray: Ray, reach, growth):
        """May the horizon lie within the angle `growth` of the ray?"""
        return abs(dot(self.normal, ray.direction)) <= growth

    def side(self, ray: Ray):
        """Does a ray that only just meets the shape come from its outer side?"""
        return dot(self.normal, ray.origin) >= self.offset

    def curvature(self):
        """The unit normal is the same everywhere."""
        return jnp.zeros_like(self.offset)

    def bounding(self):
        """Middle and radius of a sphere around the shape, which has no end."""
        return self.normal * self.offset, jnp.full_like(self.offset, jnp.inf)

    def contains(self, point: Vec3):
        return dot(self.normal, point) < self.offset

    def _crossing(self, ray: Ray):
        towards = dot(self.normal, ray.direction)
        distance = safe_divide(self.offset - dot(self.normal, ray.origin), towards)
        return distance, towards < 0


class Plane(AbstractObject):
    """The plane normal.x = offset; its inside is the half space that the normal points away from.

    The normal need not have unit length: the equation is taken as it stands.
    """

    TYPE: ClassVar[str] = "plane"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("normal", "direction", "Any length but zero.", nonzero=True, scale="unbounded", moves="rays"),
        Row("offset", "number", "Metres, where the normal has unit length.", unit="m", scale="unbounded", moves="rays"),
    )
    FAMILY: ClassVar[type[AbstractSurfaces]] = Planes
    CONVEX: ClassVar[bool] = True
    FLAT: ClassVar[bool] = True

    normal: Float[Array, "3"]
    offset: Float[Array, ""]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, normal, offset, material: str, place: str | None = None):
        self.name, self.material = name, material
        read_rows(self, place or f"object {name!r}", normal=normal, offset=offset)

    @classmethod
    def family(cls, normal, offset) -> Planes:
        normal, power = rescaled(vec3(normal))
        return Planes(normalise(normal), safe_divide(offset * power, length(normal)))

    def moved(self, by: np.ndarray) -> "Plane":
        """normal.(x - by) = offset."""
        along = sum(shifted(self.normal, 0)[k] * by[k] for k in range(3))
        return changed(self, offset=self.offset + along if is_traced(along) else shifted(self.offset, along))

    def transformed(self, linear, shift, place: str) -> "Plane":
        """n.x = offset becomes (n L^-1).y = offset + (n L^-1).shift."""
        own = jnp if is_traced(linear) else np
        normal = own.linalg.inv(linear).T @ self.normal
        return changed(self, normal=normal, offset=self.offset + normal @ shift)

    def size(self) -> Float[Array, ""]:
        return jnp.full_like(self.offset, jnp.inf)

    def half_space(self) -> tuple[np.ndarray, float]:
        normal = np.asarray(self.normal, np.float64)
        size = float(np.linalg.norm(normal))
        return normal / size, float(self.offset) / size

    def away_from(self, place: np.ndarray) -> float:
        normal, offset = self.half_space()
        return abs(float(normal @ place) - offset)

    def flat(self) -> tuple[np.ndarray, float, None]:
        return (*self.half_space(), None)
