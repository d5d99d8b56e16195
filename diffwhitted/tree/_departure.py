"""Where the rays of a block set out: at the camera, or at the surfaces that their parents met."""

from dataclasses import replace

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ..geometry import NOTHING, Departure, Footprint, Ray
from ..numerics._stage import stage
from ..numerics._vector import Vec3
from ..scene import AbstractCamera, Tables
from ._arrival import PAST, Arrival, Origin
from ._branch import child, departure
from ._chance import chances
from ._dispersion import of_band
from ._gloss import roughened
from ._lens import on_lens
from ._plan import MOST_PASSED, Plan
from ._samples import Samples


def departing(
    tables: Tables,
    camera: AbstractCamera,
    plan: Plan,
    samples: Samples,
    parents: Arrival | None,
    origin: Origin,
    alive: Bool[Array, "n"],
) -> tuple[Ray, Footprint | None, Vec3]:
    """The rays of a block, and the share of their light that goes on: camera rays, or the children of `parents`."""

    def camera_rays(parents):
        column, row = samples.column[origin.sample], samples.row[origin.sample]
        one = jnp.ones_like(column)
        lens = on_lens(tables, plan, samples, origin) if plan.effects.lens else None
        footprint = camera.footprint(column, row, samples.side, lens) if plan.footprint else None
        factor = Vec3(one, one, one)
        if plan.bands > 1:
            factor = factor * of_band(plan, samples, one.dtype)
        return camera.rays(column, row, lens), footprint, factor

    def children(parents):
        if plan.effects.gloss:
            parents = roughened(tables, plan, parents, chances(plan, samples, origin, origin.level - 1))
        return child(tables, plan, parents, origin.branch, alive.any())

    if not plan.branching:
        return stage(alive.any(), camera_rays, parents)
    return jax.lax.cond(of_camera(origin), camera_rays, children, parents)


def sides_of(plan: Plan, parents: Arrival | None, origin: Origin) -> Departure:
    """The surfaces that the rays of a block leave, if any, for the search."""

    def camera_rays(parents):
        nothing = jnp.full(origin.sample.shape, NOTHING, jnp.int32)
        return Departure(nothing, nothing >= 0, (nothing,) * (MOST_PASSED if plan.footprint else 0))

    if not plan.branching:
        return camera_rays(parents)
    return jax.lax.cond(of_camera(origin), camera_rays, lambda parents: departure(parents, origin.branch), parents)


def parents_of(origin: Origin, arrivals):
    """What stands in `arrivals` for the parent of each ray of a block; zeros for camera rays, which have none."""

    def none(arrivals):
        return jax.tree.map(lambda a: jnp.zeros(origin.sample.shape, a.dtype), arrivals)

    return jax.lax.cond(
        of_camera(origin), none, lambda arrivals: jax.tree.map(lambda a: a[origin.parent], arrivals), arrivals
    )


def run_on(plan: Plan, at: Arrival, parents: Arrival | None, origin: Origin) -> Arrival:
    """The arrival of rays some of which run on past a silhouette: these have come from where their parents set out.
    Where there are meshes they have set out there again.
    """
    if parents is None or not plan.footprint or not plan.effects.distance_fade or at.beam.outline is not None:
        return at
    before = jnp.where(origin.branch == PAST, parents.distance, 0)
    return replace(at, distance=at.distance + before)


def of_camera(origin: Origin) -> Bool[Array, ""]:
    """Is it a block of camera rays? They fill whole blocks."""
    return origin.lineage[0] == 0


def any_ray(plan: Plan, dtype) -> tuple[Ray, Footprint | None, Departure, Origin]:
    """A block of rays that only has a shape, to ask what a function gives back for it."""
    zero, index = jnp.zeros(plan.block, dtype), jnp.zeros(plan.block, jnp.int32)
    point = Vec3(zero, zero, zero)
    ray = Ray(point, point)
    footprint = Footprint(ray, ray, index) if plan.footprint else None
    departure = Departure(index, index > 0, (index,) * (MOST_PASSED if plan.footprint else 0))
    return ray, footprint, departure, Origin(index, index.astype(jnp.int8), index)
