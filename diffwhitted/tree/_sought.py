"""What the rays of a recorded tree asked of the search, to be asked again."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..geometry import Departure, Ray, surface_at
from ..illumination import before
from ..numerics._vector import Vec3, dot
from ..records import member, member_count
from ..scene import AbstractCamera, Tables
from ._arrival import Arrival, arrival
from ._departure import departing, sides_of
from ._plan import Plan
from ._record import Nodes, Record
from ._retrace import retraced
from ._samples import Samples


class ShadowRays(eqx.Module):
    """The rays from points to one light."""

    ray: Ray
    departure: Departure
    limit: Float[Array, "n"]
    """Where the light is; 0 for a ray that is not sent, as the point is turned away from the light."""


def arrivals(tables: Tables, camera: AbstractCamera, plan: Plan, samples: Samples, record: Record) -> Arrival | None:
    """How each ray of a recorded tree arrived, by the slot of its node; None where no ray has children."""

    def dark(tables: Tables, plan: Plan, nodes: Nodes, at: Arrival, needed) -> Vec3:
        zero = jnp.zeros_like(at.point.x)
        return Vec3(zero, zero, zero)

    state = retraced(dark, plan, (tables, camera, samples), record)[1]
    return None if state is None else state[0]


def sought(
    tables: Tables,
    camera: AbstractCamera,
    plan: Plan,
    samples: Samples,
    record: Record,
    arrived: Arrival | None,
    slot: Int[Array, "n"],
    there: Bool[Array, "n"],
) -> tuple[Ray, Departure, list[ShadowRays]]:
    """The rays of some nodes of a tree with the surfaces that they left, and those from where they arrived to each
    light. The nodes are all of camera rays, or none is.
    """
    nodes = jax.tree.map(lambda a: a[..., slot], record.nodes)
    parents = jax.tree.map(lambda a: a[..., nodes.origin.parent], arrived)
    ray, _, _ = departing(tables, camera, plan, samples, parents, nodes.origin, there)
    hit = surface_at(tables.shapes, ray, nodes.primitive, nodes.crossing, nodes.entering)
    start, leaves = arrival(hit, ray.direction, None, None, None).lit_from
    to_lights = []
    for lights in tables.lights:
        for number in range(member_count(lights)):
            direction, distance, _ = member(lights, number).arriving(start)
            lit = there & (nodes.primitive >= 0) & (dot(hit.shading_normal, direction) > 0)
            to_lights.append(ShadowRays(Ray(start, direction), leaves, jnp.where(lit, before(distance), 0)))
    return ray, sides_of(plan, parents, nodes.origin), to_lights
