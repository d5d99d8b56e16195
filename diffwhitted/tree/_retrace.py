"""A recorded tree once more, with plain differentiable arithmetic, block by block.

A node carries its throughput, the product of coefficients on the way to it, and adds throughput * local colour to its
pixel. There is no pass back up the tree. What is known of all rays stands in the state, at the place of their nodes.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..geometry import Footprint, Ray, surface_at
from ..numerics._stage import empty_buffers, read_block, stage, write_block
from ..numerics._vector import Vec3, where
from ..scene import AbstractCamera, Tables
from ._absorption import left_after
from ._arrival import Arrival, arrival
from ._beam import arriving
from ._departure import any_ray, departing, run_on
from ._local import local_radiance
from ._motion import as_drawn
from ._plan import Plan
from ._record import Nodes, Record
from ._samples import Samples
from ._wrinkles import Cone, any_cone, cone_of, wrinkled

Given = tuple[Tables, AbstractCamera, Samples]
"""All that a recorded tree is a differentiable function of."""
State = tuple[Arrival, Vec3] | None
"""How each ray arrived, and with what throughput; None where no ray has children."""


def light_of(tables: Tables, plan: Plan, nodes: Nodes, at: Arrival, needed) -> Vec3:
    """The light that rays bring from what they meet, surface or background."""
    met = nodes.primitive >= 0
    light = where(met, local_radiance(tables, plan, nodes, at, needed), _far_away(tables, at, ~met))
    return light if at.beam is None else light * at.beam.edge.coverage


def _far_away(tables: Tables, at: Arrival, missed: Bool[Array, "n"]) -> Vec3:
    """The background along the rays, or its mean over their share of the pixel."""
    if at.beam is None:
        return tables.background.seen(at.direction)
    steps = tuple(side.direction for side in at.beam.footprint.sides())
    return tables.background.mean(at.direction, steps, missed)


def retraced(light_of: Callable, plan: Plan, given: Given, record: Record) -> tuple[Vec3, State]:
    """The film of a recorded tree, and its state. Differentiable in forward mode: the loop is as long as the tree."""

    def follow_block(number, carry):
        film, state = carry
        start, nodes, alive = block_of(plan, given[-1], record, number)
        added, here = visit(light_of, plan, given, nodes, parents_of(nodes, state), alive)
        film = jax.tree.map(lambda f, a: f.at[nodes.origin.sample].add(a), film, added)
        return film, None if here is None else write_block(state, here, start)

    tables, one = given[0], jnp.ones(plan.block, given[0].cutoff.dtype)
    ray, footprint, _, _ = any_ray(plan, one.dtype)
    nodes, white = read_block(record.nodes, 0, plan.block), Vec3(one, one, one)
    cone = any_cone(plan, ray)
    arrived = jax.eval_shape(lambda: _arrived(tables, nodes, ray, footprint, cone, jnp.bool_(True)))
    state = empty_buffers((arrived, white), plan.slots) if plan.branching else None
    film = empty_buffers(white, plan.pass_pixels)
    return jax.lax.fori_loop(0, blocks_there(record), follow_block, (film, state))


def visit(
    light_of: Callable, plan: Plan, given: Given, nodes: Nodes, parents: State, alive: Bool[Array, "n"]
) -> tuple[Vec3, State]:
    """What the nodes of a block add to the film, and their part of the state."""
    tables, camera, samples = given
    tables, camera = as_drawn(tables, camera, plan, samples)
    at, throughput = (None, None) if parents is None else parents
    ray, footprint, factor = departing(tables, camera, plan, samples, at, nodes.origin, alive)
    if parents is not None:
        # Camera rays read the first node for nothing: a branch without it would cost reverse mode a state of zeros.
        throughput = where(nodes.origin.lineage == 0, jax.tree.map(jnp.ones_like, throughput), throughput)
    throughput = factor if parents is None else throughput * factor
    cone = cone_of(camera, plan, samples, at, nodes.origin, ray)
    arrived = _arrived(tables, nodes, ray, footprint, cone, alive.any())
    if plan.effects.absorption:
        throughput = throughput * left_after(tables, plan, at, nodes.origin, arrived)
    arrived = run_on(plan, arrived, at, nodes.origin)
    added = throughput * light_of(tables, plan, nodes, arrived, alive.any())
    return masked(alive, added), None if parents is None else (arrived, throughput)


def block_of(plan: Plan, samples: Samples, record: Record, number: Int[Array, ""]):
    """Where a block begins, its nodes, and which of its lanes are rays."""
    start, end = record.starts[number], record.ends[number]
    nodes = read_block(record.nodes, start, plan.block)
    alive = (start + jnp.arange(plan.block) < end) & samples.there[nodes.origin.sample]
    # What is no ray repeats the first one of the block, so that it is finite on the way back too.
    return start, jax.tree.map(lambda a: jnp.where(alive, a, a[..., :1]), nodes), alive


def blocks_there(record: Record) -> Int[Array, ""]:
    """How many blocks the tree has."""
    return jnp.sum(record.ends > record.starts)


def parents_of(nodes: Nodes, state: State) -> State:
    """The state of the parent of each node; of camera rays that of the first node."""
    return jax.tree.map(lambda a: a[nodes.origin.parent], state)


def masked(alive: Bool[Array, "n"], values):
    """Zeros in the lanes that are no rays. They may hold NaN, which times zero is NaN again."""
    return jax.tree.map(lambda a: jnp.where(alive, a, 0), values)


def _arrived(tables: Tables, nodes: Nodes, ray: Ray, footprint: Footprint | None, cone: Cone | None, needed) -> Arrival:
    """How a ray arrives at its recorded surface."""
    surface = nodes.primitive, nodes.crossing, nodes.entering
    if footprint is None:
        hit = stage(needed, lambda *a: surface_at(tables.shapes, *a), ray, *surface)
        return wrinkled(tables, arrival(hit, ray.direction, nodes.outside, nodes.inside, None), cone, needed)
    hit, direction, beam = arriving(tables.shapes, ray, footprint, *surface, nodes.cut, nodes.outline, None, needed)
    return arrival(hit, direction, nodes.outside, nodes.inside, beam)
