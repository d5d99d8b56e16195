"""Recompute a recorded tree with plain differentiable arithmetic, and add up its light.

A node carries its throughput, the product of coefficients on the way to it, and adds throughput * local
colour to its pixel. There is no pass back up the tree. Forward and reverse mode both work.
"""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._vector import Vec3, where
from ..geometry import Ray, surface_at
from ..scene import Camera, Tables
from ._branch import Arrival, arrival, child_ray, share
from ._local import local_radiance
from ._plan import Plan
from ._record import Nodes, Record
from ._stage import empty_buffers, read_block, stage, write_block


def replay(tables: Tables, camera: Camera, record: Record, plan: Plan, number: Int[Array, ""],
           offset: Float[Array, "2"]) -> Vec3:
    """Linear RGB of the pixels of pass `number`, three arrays of shape (plan.pass_pixels,).

    Differentiable in `tables` and `camera`, along the recorded tree.
    """
    pixels = camera.width * camera.height
    one = jnp.ones(plan.slots, tables.ambient.dtype)

    @partial(jax.checkpoint, prevent_cse=False)
    def visit_camera_rays(nodes: Nodes):
        pixel = plan.picture_pixel(number, nodes.origin.pixel)
        needed = pixel[0] < pixels
        ray = stage(needed, camera.pixel_rays, jnp.minimum(pixel, pixels - 1), offset)
        return _visit(tables, plan, nodes, ray, needed)

    def camera_block(carry, start):
        film, arrivals = carry
        light, arrived = visit_camera_rays(read_block(record.nodes, start, plan.block))
        return (write_block(film, light, start), write_block(arrivals, arrived, start)), None

    shapes = jax.eval_shape(visit_camera_rays, read_block(record.nodes, jnp.int32(0), plan.block))
    film, arrivals = empty_buffers(shapes[0], plan.pass_pixels), empty_buffers(shapes[1], plan.slots)
    starts = jnp.arange(plan.blocks, dtype=jnp.int32) * plan.block
    (film, arrivals), _ = jax.lax.scan(camera_block, (film, arrivals), starts)
    if not plan.effects.branching:
        return film
    return _descend(tables, plan, record, film, (arrivals, Vec3(one, one, one)))


def _descend(tables: Tables, plan: Plan, record: Record, film: Vec3, state: tuple[Arrival, Vec3]) -> Vec3:
    """The blocks of descendants, in the order in which they were recorded; `state` is arrivals and throughputs."""

    @partial(jax.checkpoint, prevent_cse=False)
    def visit_children(nodes: Nodes, at: Arrival, throughput: Vec3, alive):
        branch = nodes.origin.lineage % 4
        ray, _ = stage(alive[0], lambda *a: child_ray(tables, plan, *a), at, branch)
        throughput = throughput * share(tables, plan, at.object, branch)
        radiance, arrived = _visit(tables, plan, nodes, ray, alive[0])
        added = throughput * radiance
        return where(alive, added, added * 0), (arrived, throughput)

    def child_block(carry, bounds):
        start, end = bounds

        def follow(carry):
            film, state = carry
            nodes = read_block(record.nodes, start, plan.child_block)
            at, throughput = jax.tree.map(lambda a: a[nodes.origin.lineage // 4], state)
            alive = start + jnp.arange(plan.child_block) < end
            added, arrived = visit_children(nodes, at, throughput, alive)
            film = jax.tree.map(lambda f, a: f.at[nodes.origin.pixel].add(a), film, added)
            return film, write_block(state, arrived, start)

        return jax.lax.cond(end > start, follow, lambda carry: carry, carry), None

    (film, _), _ = jax.lax.scan(child_block, (film, state), (record.starts, record.ends))
    return film


def _visit(tables: Tables, plan: Plan, nodes: Nodes, ray: Ray, needed) -> tuple[Vec3, Arrival]:
    """One ray to its surface: the light that it brings, and what its children start from."""
    hit = stage(needed, lambda *a: surface_at(tables.shapes, *a), ray, nodes.object, nodes.entering)
    local = local_radiance(tables, plan, nodes, hit, ray.direction, needed)
    light = where(nodes.object >= 0, local, tables.background.seen(ray.direction))
    return light, arrival(hit, ray.direction, nodes.outside)
