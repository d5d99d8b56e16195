"""How rays change across their pixel (Igehy 1999, ray differentials), and what an edge leaves of a pixel.

A footprint is carried along with a ray: its derivative along the two sides of the pixel. Whatever the ray meets
is known to first order over the whole pixel.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._coverage import Linear, coverage, ramp
from ..numerics._safe import normalise, safe_sqrt
from ..numerics._vector import Vec3, dot, where
from ._hit import Hit
from ._ray import Ray

LEAST_COVERAGE = 1e-3
"""An edge that leaves less than this share of a pixel on one side does not count as one."""
STEEPEST = 0.001
"""Cosine below which a grazing ray spreads no further over the surface that it meets."""


class Footprint(eqx.Module):
    """The change of a ray from one side of its pixel to the other."""

    across: Ray
    """Along the row."""
    down: Ray
    """Along the column."""
    within: Int[Array, "*n"] | None = None
    """The object that the ray was refracted into and has not left, -1 for none. None for a ray to a light."""

    def sides(self) -> tuple[Ray, Ray]:
        return self.across, self.down

    def reach(self) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """How far the origin and the direction change from the middle of the pixel to a corner, at most. No
        derivatives.
        """
        origin, direction = (
            dot(a, a) + dot(b, b)
            for a, b in ((self.across.origin, self.down.origin), (self.across.direction, self.down.direction))
        )
        return jnp.sqrt(0.5 * origin), jnp.sqrt(0.5 * direction)


class Edge(eqx.Module):
    """The silhouette of an object through a pixel: how much of it is covered, and where."""

    coverage: Float[Array, "*n"]
    """Of the pixel; 1 where no edge is."""
    across: Float[Array, "*n"]
    down: Float[Array, "*n"]
    """The unit vector in the pixel towards the covered side; zero where no edge is."""
    shift: Float[Array, "*n"]
    """From the middle of the pixel to the middle of the covered part, along that vector."""


def edge_of(silhouette: Linear, here: Bool[Array, "*n"]) -> Edge:
    """The edge of a silhouette (positive on the object) where one is `here`."""
    silhouette = Linear(
        *(
            jnp.where(here, a, b)
            for a, b in zip((silhouette.value, silhouette.across, silhouette.down), (0.0, 1.0, 0.0), strict=True)
        )
    )
    share = jnp.clip(coverage(silhouette), LEAST_COVERAGE, 1 - LEAST_COVERAGE)
    steepness_squared = silhouette.across * silhouette.across + silhouette.down * silhouette.down
    steep = steepness_squared > 0
    steepness = jnp.sqrt(jnp.where(steep, steepness_squared, 1))
    here = here & steep
    shift = (ramp(silhouette) / share - silhouette.value) / steepness
    zero = jnp.zeros_like(share)
    return Edge(
        *(
            jnp.where(here, a, b)
            for a, b in (
                (share, zero + 1),
                (silhouette.across / steepness, zero),
                (silhouette.down / steepness, zero),
                (shift, zero),
            )
        )
    )


def covered(ray: Ray, footprint: Footprint, edge: Edge) -> tuple[Ray, Footprint]:
    """The ray through the middle of the covered part of the pixel, and the footprint of that part."""
    return part_of(ray, footprint, edge, edge.coverage, edge.shift)


def uncovered(ray: Ray, footprint: Footprint, edge: Edge) -> tuple[Ray, Footprint]:
    """The ray through the middle of the rest of the pixel, and the footprint of the rest, from those of the covered
    part.

    The middles are `shift` and -`shift` share / (1 - share) from that of the pixel, which is `shift` / (1 - share)
    apart; along the edge's direction the covered part changes by `share` of what the whole pixel does.
    """
    covered_share = jnp.where(edge.coverage > 0, edge.coverage, 1)
    rest = jnp.where(edge.coverage < 1, 1 - edge.coverage, 1)
    return part_of(ray, footprint, edge, rest / covered_share, -edge.shift / (rest * covered_share))


def crosswise(footprint: Footprint, direction: Vec3) -> Footprint:
    """The same rays with origins that move across the direction only, however far along it a surface has moved them."""

    def one(side: Ray) -> Ray:
        return Ray(side.origin - direction * dot(side.origin, direction), side.direction)

    return Footprint(one(footprint.across), one(footprint.down), footprint.within)


def part_of(ray: Ray, footprint: Footprint, edge: Edge, share, shift) -> tuple[Ray, Footprint]:
    """The ray `shift` along the edge's vector from the middle of the pixel, and the footprint of a `share` of it."""

    def towards(a: Vec3, b: Vec3) -> Vec3:
        return a * edge.across + b * edge.down

    origin = towards(footprint.across.origin, footprint.down.origin)
    direction = towards(footprint.across.direction, footprint.down.direction)
    cut = shift != 0
    moved = Ray(ray.origin + origin * shift, where(cut, normalise(ray.direction + direction * shift), ray.direction))
    return moved, narrowed(footprint, edge, share)


def narrowed(footprint: Footprint, edge: Edge, share: Float[Array, "*n"]) -> Footprint:
    """The footprint of a `share` of the pixel, cut across the edge's direction."""
    lost = 1 - share

    def one(name: str) -> tuple[Vec3, Vec3]:
        across, down = getattr(footprint.across, name), getattr(footprint.down, name)
        towards = (across * edge.across + down * edge.down) * lost
        return across - towards * edge.across, down - towards * edge.down

    origin, direction = one("origin"), one("direction")
    return Footprint(Ray(origin[0], direction[0]), Ray(origin[1], direction[1]), footprint.within)


def steps_on_surface(
    ray: Ray, footprint: Footprint, point: Vec3, normal: Vec3, curvature: Float[Array, "*n"] | float = 0
) -> list[Vec3]:
    """How the point where the ray meets the surface moves along it, from one side of the pixel to the other.

    dP = q - d (q.N) / (d.N) with q = dO + t dD: the surface is its tangent plane to first order. Edges: where
    |d.N| < 0.001 the footprint is that of 0.001; on a surface that is curved, a pixel of width w = |q.N| reaches no
    further than the sqrt(2 w / curvature) from where it grazes the surface to w below.
    """
    distance = dot(point - ray.origin, ray.direction)
    free = [side.origin + side.direction * distance for side in footprint.sides()]
    width = abs(dot(free[0], normal)) + abs(dot(free[1], normal))
    towards = -jnp.maximum(jnp.maximum(-dot(ray.direction, normal), STEEPEST), safe_sqrt(0.5 * width * abs(curvature)))
    return [q - ray.direction * (dot(q, normal) / towards) for q in free]


def on_surface(ray: Ray, footprint: Footprint, hit: Hit, curvature: Float[Array, "*n"] | float = 0) -> Footprint:
    """The footprint where the ray meets the surface: its origin moves along the surface."""
    moved = steps_on_surface(ray, footprint, hit.point, hit.normal, curvature)
    across, down = (Ray(origin, side.direction) for origin, side in zip(moved, footprint.sides(), strict=True))
    return Footprint(across, down, footprint.within)
