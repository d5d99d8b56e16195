"""Where the rays of a block set out: at the camera, or at the surfaces that their parents met."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._vector import Vec3
from ..geometry import NOTHING, Departure, Ray
from ..scene import Camera, Tables
from ._branch import Arrival, Origin, child_ray
from ._plan import Plan
from ._stage import stage


def departing(tables: Tables, camera: Camera, plan: Plan, number: Int[Array, ""], offset: Float[Array, "2"],
              parents: Arrival, origin: Origin, alive: Bool[Array, "n"]) -> tuple[Ray, Departure]:
    """The rays of a block: camera rays through `offset` inside their pixels, or the children of `parents`."""

    def camera_rays(parents):
        pixel = jnp.minimum(plan.picture_pixel(number, origin.pixel), camera.width * camera.height - 1)
        ray = camera.pixel_rays(pixel, offset)
        return ray, Departure(jnp.full(pixel.shape, NOTHING, jnp.int32), jnp.zeros(pixel.shape, bool))

    def children(parents):
        return child_ray(tables, plan, parents, origin.lineage % 4)

    if not plan.effects.branching:
        return stage(alive[0], camera_rays, parents)
    return jax.lax.cond(of_camera(origin), camera_rays, children, parents)


def parents_of(origin: Origin, arrivals):
    """What stands in `arrivals` for the parent of each ray of a block; zeros for camera rays, which have none."""
    parent = origin.lineage // 4

    def none(arrivals):
        return jax.tree.map(lambda a: jnp.zeros(parent.shape, a.dtype), arrivals)

    return jax.lax.cond(of_camera(origin), none, lambda arrivals: jax.tree.map(lambda a: a[parent], arrivals), arrivals)


def of_camera(origin: Origin) -> Bool[Array, ""]:
    """Is it a block of camera rays? They fill whole blocks."""
    return origin.level[0] == 1


def any_ray(plan: Plan, dtype) -> tuple[Ray, Departure, Origin]:
    """A block of rays that only has a shape, to ask what a function gives back for it."""
    zero, index = jnp.zeros(plan.block, dtype), jnp.zeros(plan.block, jnp.int32)
    point = Vec3(zero, zero, zero)
    return Ray(point, point), Departure(index, index > 0), Origin(index, index.astype(jnp.int8), index)
