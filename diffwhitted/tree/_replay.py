"""Recompute a recorded tree with plain differentiable arithmetic, and add up its light.

A node carries its throughput, the product of coefficients on the way to it, and adds throughput * local
colour to its pixel. There is no pass back up the tree. Forward and reverse mode both work.
"""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Int

from ..geometry import Footprint, Ray, beside_small, surface_at
from ..numerics._safe import length
from ..numerics._stage import empty_buffers, read_block, stage, write_block
from ..numerics._vector import Vec3, vec3, where
from ..scene import Camera, Tables
from ._arrival import Arrival, arrival
from ._beam import arriving
from ._departure import any_ray, departing
from ._local import local_radiance
from ._plan import Plan
from ._record import Nodes, Record, follow
from ._samples import Samples
from ._truncation import Beyond


def light_of(tables: Tables, plan: Plan, nodes: Nodes, at: Arrival, needed) -> Vec3:
    """The light that rays bring from what they meet, surface or background."""
    light = where(
        nodes.primitive >= 0, local_radiance(tables, plan, nodes, at, needed), tables.background.seen(at.direction)
    )
    return light if at.beam is None else light * at.beam.edge.share


def replay(
    tables: Tables,
    camera: Camera,
    record: Record,
    plan: Plan,
    samples: Samples,
    light_of: Callable = light_of,
    forward: bool = False,
) -> Vec3:
    """Linear RGB of the samples of a pass, three arrays of shape (plan.pass_pixels,).

    Differentiable in `tables` and `camera`, along the recorded tree. `light_of` stands in place of the light of a node.
    `forward`: no reverse mode is wanted, so the loop need not pass by all the blocks that there might be.
    """
    branching = plan.branching

    def visit(nodes: Nodes, parents: Arrival | None, throughput: Vec3, alive):
        ray, footprint, factor = departing(tables, camera, plan, samples, parents, nodes.origin, alive)
        throughput = throughput * factor
        arrived = _arrived(tables, plan, nodes, ray, footprint, alive.any())
        added = throughput * light_of(tables, plan, nodes, arrived, alive.any())
        return jax.tree.map(lambda a: jnp.where(alive, a, 0), added), (arrived, throughput)

    if not forward:
        visit = jax.checkpoint(visit, prevent_cse=False)

    def follow_block(start, end, carry):
        film, state = carry
        nodes = read_block(record.nodes, start, plan.block)
        alive = (start + jnp.arange(plan.block) < end) & samples.there[nodes.origin.sample]
        # What is not alive repeats the first ray of the block, so that it is finite on the way back too.
        nodes = jax.tree.map(lambda a: jnp.where(alive, a, a[..., :1]), nodes)
        # Camera rays read the first node for nothing: a branch without it would cost reverse mode a whole state of zeros.
        parents, throughput = jax.tree.map(lambda a: a[nodes.origin.parent], state) if branching else (None, white)
        throughput = where(nodes.origin.lineage == 0, white, throughput)
        added, arrived = visit(nodes, parents, throughput, alive)
        film = jax.tree.map(lambda f, a: f.at[nodes.origin.sample].add(a), film, added)
        return film, write_block(state, arrived, start) if branching else state

    def follow_if_there(carry, bounds):
        start, end = bounds
        return jax.lax.cond(end > start, partial(follow_block, start, end), lambda carry: carry, carry), None

    one = jnp.ones(plan.block, tables.ambient.dtype)
    white = Vec3(one, one, one)
    ray, footprint, _, _ = any_ray(plan, one.dtype)
    arrived = jax.eval_shape(
        lambda: _arrived(tables, plan, read_block(record.nodes, 0, plan.block), ray, footprint, jnp.bool_(True))
    )
    state = empty_buffers((arrived, white), plan.slots) if branching else ()
    carry = empty_buffers(white, plan.pass_pixels), state
    if forward:
        there = jnp.sum(record.ends > record.starts)
        return jax.lax.fori_loop(
            0, there, lambda number, carry: follow_block(record.starts[number], record.ends[number], carry), carry
        )[0]
    return jax.lax.scan(follow_if_there, carry, (record.starts, record.ends))[0][0]


def _arrived(tables: Tables, plan: Plan, nodes: Nodes, ray: Ray, footprint: Footprint | None, needed) -> Arrival:
    """How a ray arrives at its recorded surface."""
    surface = nodes.primitive, nodes.crossing, nodes.entering
    if footprint is None:
        hit = stage(needed, lambda *a: surface_at(tables.shapes, *a), ray, *surface)
        return arrival(hit, ray.direction, nodes.outside, None)
    hit, direction, beam = arriving(tables.shapes, ray, footprint, *surface, nodes.cut, None, needed)
    return arrival(hit, direction, nodes.outside, beam)


def trace(
    tables: Tables, camera: Camera, plan: Plan, samples: Samples, beyond: Beyond | None = None
) -> tuple[Vec3, Vec3 | None, Int[Array, ""]]:
    """What `record` and `replay` give, in one go and without derivatives: the film, and the number of descendants.

    Between the two, where `beyond` is given, the most light that the branches that were not followed could bring.
    """
    tree, ((film,), left) = follow(
        tables, camera, plan, samples, lambda nodes, ray, *a: (light_of(tables, plan, nodes, *a),), beyond
    )
    return film, left, tree.descendants


def trace_left_out(
    tables: Tables, camera: Camera, plan: Plan, samples: Samples, beyond: Beyond
) -> tuple[Vec3, Int[Array, ""]]:
    """Of what `trace` gives with `beyond` only what is left out, and the number of descendants. `plan` must weigh its rays: have a cutoff."""
    tree, (_, left) = follow(tables, camera, plan, samples, beyond=beyond)
    return left, tree.descendants


def trace_beside_small(
    tables: Tables, camera: Camera, plan: Plan, samples: Samples
) -> tuple[Vec3, Vec3, Int[Array, ""]]:
    """What `trace` gives, and between the two how much light comes along rays that pass by something smaller than their distance."""
    apart = samples.side * camera.pixel_angle()

    def both(nodes: Nodes, ray: Ray, at: Arrival, needed):
        reach = length(ray.origin - vec3(camera.look_from)) * apart
        limit = jnp.where(nodes.primitive < 0, jnp.inf, length(at.point - ray.origin))
        beside = stage(
            needed, lambda *a: beside_small(tables.shapes, *a), ray, reach, apart * jnp.ones_like(reach), limit
        )
        one = beside.astype(at.point.x.dtype)
        return light_of(tables, plan, nodes, at, needed), Vec3(one, one, one)

    tree, ((film, beside), _) = follow(tables, camera, plan, samples, both, kinds=2)
    return film, beside, tree.descendants
