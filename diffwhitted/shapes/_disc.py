"""Flat discs."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import LEAST_COVERAGE, AbstractSurfaces, Footprint, Ray, steps_on_surface
from ..numerics._coverage import Linear, is_cut
from ..numerics._safe import length, normalise, rescaled
from ..numerics._vector import Vec3, dot, vec3, where
from ..records import Row, read_rows
from ._object import AbstractObject
from ._plane import Planes

CORNERS = 48
"""Of the polygon that stands for a disc where corners are asked for."""


class Discs(AbstractSurfaces):
    """Discs by centre, unit normal and radius (arrays over the discs, or over rays)."""

    FOOTPRINT: ClassVar[bool] = True

    centre: Vec3
    normal: Vec3
    radius: Float[Array, "*n"]

    def surface(self, ray: Ray, crossing):
        """That of the plane that carries the disc."""
        return self.carrier().surface(ray, crossing)

    def carrier(self) -> Planes:
        """The plane that carries the disc."""
        return Planes(self.normal, dot(self.normal, self.centre))

    def crossings(self, ray: Ray, on_it, inwards):
        """The crossing of the plane (Hearn and Baker 14-62), where it is nearer to the centre than the radius."""
        (distance,) = self.carrier().crossings(ray, on_it, inwards)
        met = jnp.isfinite(distance)
        return (jnp.where(met & self.covers(ray.at(jnp.where(met, distance, 0))), distance, jnp.inf),)

    def covers(self, point: Vec3):
        away = point - self.centre
        return dot(away, away) < self.radius * self.radius

    def silhouette(self, ray: Ray, footprint: Footprint):
        """Distance in the plane from where the ray meets it to the rim, positive inside; and how far that is."""
        distance, _, point, _ = self.surface(ray, None)
        facing = where(self.side(ray), self.normal, -self.normal)
        steps = steps_on_surface(ray, footprint, point, facing)
        away = point - self.centre
        outwards = normalise(away)
        return Linear(self.radius - length(away), *(-dot(outwards, step) for step in steps)), distance

    def near_silhouette(self, ray: Ray, reach, growth):
        """May the rim lie within `reach` + `growth` times the distance of the ray's line?

        A point of the plane that is e away from where the line meets it is at least e |N.u| away from the line.
        """
        distance, _, point, _ = self.surface(ray, None)
        to_centre, away = self.centre - ray.origin, point - self.centre
        around = reach + growth * (jnp.sqrt(dot(to_centre, to_centre)) + self.radius)
        inwards = abs(jnp.sqrt(dot(away, away)) - self.radius) * abs(dot(self.normal, ray.direction))
        miss = to_centre - ray.direction * dot(to_centre, ray.direction)
        apart = self.radius + around
        return (inwards <= around) & (dot(miss, miss) <= apart * apart)

    def side(self, ray: Ray):
        """Does a ray that only just meets the shape come from its outer side?"""
        return self.carrier().side(ray)

    def bordered(self, ray: Ray, footprint: Footprint):
        return is_cut(self.silhouette(ray, footprint)[0], LEAST_COVERAGE)

    def bounding(self):
        """Middle and radius of a sphere around the shape."""
        return self.centre, self.radius


class Disc(AbstractObject):
    """A flat disc: centre and radius in metres, and the normal of its outer side."""

    TYPE: ClassVar[str] = "disc"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("centre", "vector", "Centre, metres.", unit="m", scale="unbounded", moves="rays"),
        Row("normal", "direction", "Of the outer side; any length but zero.", nonzero=True, scale="unbounded",
            moves="rays"),
        Row("radius", "number", "Radius, metres.", unit="m", lowest=0, excluded=True, scale="log", moves="rays"),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Discs
    CONVEX: ClassVar[bool] = True
    FLAT: ClassVar[bool] = True

    centre: Float[Array, "3"]
    normal: Float[Array, "3"]
    radius: Float[Array, ""]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name: str, centre, normal, radius, material: str, place: str | None = None):
        self.name, self.material = name, material
        read_rows(self, place or f"object {name!r}", centre=centre, normal=normal, radius=radius)

    @classmethod
    def family(cls, centre, normal, radius) -> Discs:
        return Discs(vec3(centre), normalise(rescaled(vec3(normal))[0]), radius)

    def away_from(self, place: np.ndarray) -> float:
        normal, offset, _ = self.flat()
        rise = float(normal @ place) - offset
        aside = float(np.linalg.norm(place - rise * normal - np.asarray(self.centre, np.float64)))
        return float(np.hypot(rise, max(0.0, aside - float(self.radius))))

    def flat(self) -> tuple[np.ndarray, float, np.ndarray]:
        """With the corners of a polygon inscribed in it."""
        normal, centre = (np.asarray(v, np.float64) for v in (self.normal, self.centre))
        normal = normal / np.linalg.norm(normal)
        across = np.cross(np.eye(3)[abs(normal).argmin()], normal)
        across /= np.linalg.norm(across)
        turn = 2 * np.pi * np.arange(CORNERS)[:, None] / CORNERS
        rim = np.cos(turn) * across + np.sin(turn) * np.cross(normal, across)
        return normal, float(normal @ centre), centre + float(self.radius) * rim
