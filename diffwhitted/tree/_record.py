"""Follow the tree of rays and write down what is discrete.

Which surface each ray meets and from which side, which rays it sends on, and what each light sees. There is
no derivative here. The rays form a queue: the camera rays come first; a block of rays is taken from the
front, its surfaces are searched for, and the children that carry light are appended at the end, packed
together. The cost follows the rays that exist.
"""

from collections.abc import Callable
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..geometry import (
    Departure,
    Footprint,
    Ray,
    divided,
    in_order,
    near_silhouettes,
    nearest,
    nearest_part,
    surface_at,
)  # fmt: skip
from ..numerics._stage import empty_buffers, packed, running_count, stage, write_block
from ..numerics._vector import Vec3, brightest, where
from ..scene import AbstractCamera, Tables
from ._absorption import left_after
from ._arrival import BRANCHES, PAST, TRANSMITTED, Arrival, Origin, arrival
from ._beam import arriving
from ._branch import branches
from ._chance import chances
from ._departure import any_ray, departing, parents_of, run_on, sides_of
from ._gloss import roughened
from ._media import media
from ._motion import as_drawn
from ._plan import Plan
from ._samples import Samples, Window
from ._shadows import Seen, shadows_at
from ._truncation import Beyond, followed, left_out
from ._wrinkles import Cone, any_cone, cone_of, wrinkled


class Nodes(eqx.Module):
    """What is discrete about rays, one entry a ray."""

    primitive: Int[Array, "n"]
    """The surface met; -1 for the background."""
    crossing: Int[Array, "n"]
    """Which of the ray's crossings with it."""
    entering: Bool[Array, "n"]
    outside: Int[Array, "n"] | None
    """The solid around the object, where media are nested."""
    inside: Int[Array, "n"] | None
    """The object whose index counts on the inner side, where surfaces lie in one place."""
    seen: tuple[Seen, ...]
    """For each group of lights, what they see of the point. Empty where nothing casts shadows."""
    cut: Bool[Array, "n"] | None
    """The silhouette of the surface cuts the pixel; None where rays have no footprint."""
    outline: Int[Array, "n"] | None
    """The number of that silhouette, of a mesh that of a side, -1 for none; None where no mesh is: the surface."""
    origin: Origin


class Record(eqx.Module):
    """The tree of one pass: all its nodes, the camera rays first, then the others in the order of the queue."""

    nodes: Nodes
    starts: Int[Array, "blocks"]
    """First node of each block, in the order in which the blocks were followed. Blocks that were not needed
    start, and end, in the spare room past all nodes."""
    ends: Int[Array, "blocks"]
    descendants: Int[Array, ""]
    """How many there are; more than the plan's capacity means that some were not followed."""


def record(
    tables: Tables, camera: AbstractCamera, plan: Plan, samples: Samples, window: Window | None = None
) -> Record:
    """The tree of the samples of a pass, or of a window of them."""
    tables, camera, samples = jax.lax.stop_gradient((tables, camera, samples))
    return follow(*as_drawn(tables, camera, plan, samples), plan, samples, window=window)[0]


def follow(
    tables: Tables,
    camera: AbstractCamera,
    plan: Plan,
    samples: Samples,
    light_of: Callable | None = None,
    beyond: Beyond | None = None,
    kinds: int = 1,
    window: Window | None = None,
):
    """The tree of a pass and, where `light_of(nodes, rays, arrivals, needed)` is given, its `kinds` of light on the
    film; where `beyond` is given, also the most light that the branches that are not followed could bring.

    Blocks are taken from the front of the queue until it is empty or the room is used up. Of a `window` of the samples
    the tree is given up as soon as it outgrows the room.
    """
    samples, cameras = (samples, plan.pass_pixels) if window is None else window.of(plan, samples)
    room = cameras + plan.capacity
    one = jnp.ones(plan.block, tables.cutoff.dtype)
    white = Vec3(one, one, one)
    weighed = light_of is not None or plan.effects.cutoff or plan.zero_weights
    lit = light_of is not None and window is not None
    bounded = beyond is not None and plan.branching
    follow_rays = jax.jit(partial(_follow, tables, plan, samples))  # traced once, for its shapes and for its results

    def waiting(q: _Queue):
        return (q.start < jnp.minimum(q.count, room)) & ((window is None) | (q.count <= room))

    def follow_block(q: _Queue) -> _Queue:
        # Take a block of rays from the front of the queue.
        end = jnp.minimum(jnp.minimum(q.start + plan.block, q.count), room)
        slot = q.start + jnp.arange(plan.block, dtype=jnp.int32)
        origin = _origin(plan, q.nodes.origin, slot, q.lineage, cameras, window)
        alive = (slot < end) & samples.there[origin.sample]
        # Send them out from the camera, or from where their parents arrived.
        parents, throughput = parents_of(origin, (q.arrivals, q.throughputs)) if plan.branching else (None, white)
        ray, footprint, factor = departing(tables, camera, plan, samples, parents, origin, alive)
        sides = sides_of(plan, parents, origin)
        cone = cone_of(camera, plan, samples, parents, origin, ray)
        if weighed:
            throughput = where(origin.lineage == 0, white, throughput) * factor
        # Find the surfaces that they meet, what lights see of these points, and the rays that go on from there.
        dark = brightest(throughput) <= 0 if weighed else one < 0
        nodes, at, children = follow_rays(ray, footprint, sides, origin, cone, dark, alive.any())
        if weighed and plan.effects.absorption:
            throughput = throughput * left_after(tables, plan, parents, origin, at)
        at = run_on(plan, at, parents, origin)
        lineage, count, sends = q.lineage, q.count, None
        if plan.branching:
            sends = followed(tables, plan, at, origin.level, throughput, children, alive.any(), lit)
            lineage, count = _append(lineage, count, slot, sends, alive)
        # Add to the film the light that they bring, and the most that is left out.
        lost = left_out(tables, plan, beyond, at, throughput, children, sends, alive.any()) if bounded else None
        light = tuple(throughput * part for part in light_of(nodes, ray, at, alive.any())) if light_of else None
        film = jax.tree.map(lambda f, a: f.at[origin.sample].add(jnp.where(alive, a, 0)), q.film, (light, lost))
        # Write down the block.
        buffers = write_block(
            (q.nodes, q.arrivals, q.throughputs), (nodes, at, throughput if weighed else None), q.start
        )
        bounds = q.starts.at[q.block].set(q.start), q.ends.at[q.block].set(end)
        return _Queue(end, q.block + 1, lineage, count, *buffers, *bounds, film)

    # Begin with the camera rays of the pass, and room for all that may follow.
    blank = any_ray(plan, one.dtype)
    shapes = jax.eval_shape(follow_rays, *blank, any_cone(plan, blank[0]), one > 0, jnp.bool_(True))[:2]
    buffers = empty_buffers((*shapes, white if weighed else None), plan.slots)
    film = empty_buffers(((white,) * kinds if light_of else None, white if bounded else None), plan.pass_pixels)
    lineage, bounds = jnp.zeros(plan.slots, jnp.int32), jnp.full(plan.blocks, room, jnp.int32)
    first = _Queue(jnp.int32(0), jnp.int32(0), lineage, jnp.int32(cameras), *buffers, bounds, bounds, film)
    last = jax.lax.while_loop(waiting, follow_block, first)
    return Record(last.nodes, last.starts, last.ends, last.count - cameras), last.film


class _Queue(eqx.Module):
    """The rays of a pass in the order in which they are followed, and what is known of those behind the front."""

    start: Int[Array, ""]
    """The front: the first ray that has not been followed."""
    block: Int[Array, ""]
    """How many blocks have been followed."""
    lineage: Int[Array, "slots"]
    """Parent and branch of each ray (see `Origin`)."""
    count: Int[Array, ""]
    """Rays in the queue; more than the room means that some were not kept."""
    nodes: Nodes
    arrivals: Arrival
    throughputs: Vec3 | None
    starts: Int[Array, "blocks"]
    ends: Int[Array, "blocks"]
    film: tuple
    """Light of each kind, and the most that is left out."""


def _origin(
    plan: Plan, known: Origin, slot: Int[Array, "n"], queue: Int[Array, "slots"], cameras, window: Window | None
) -> Origin:
    """Where the rays of a block come from: camera rays fill whole blocks, the first ones of a pass."""

    def camera(known, queue):
        sample = slot if window is None else window.sample(plan, slot)
        return Origin(sample, jnp.ones(slot.shape, jnp.int8), jnp.zeros_like(slot))

    def children(known, queue):
        lineage = jax.lax.dynamic_slice_in_dim(queue, slot[0], plan.block)
        parent = lineage // BRANCHES
        deeper = (lineage % BRANCHES != PAST).astype(jnp.int8)
        return Origin(known.sample[parent], known.level[parent] + deeper, lineage)

    return jax.lax.cond(slot[0] < cameras, camera, children, known, queue) if plan.branching else camera(known, queue)


def _follow(
    tables: Tables,
    plan: Plan,
    samples: Samples,
    ray: Ray,
    footprint: Footprint | None,
    departure: Departure,
    origin: Origin,
    cone: Cone | None,
    dark,
    needed,
):
    """Find the surface that each ray meets: its node, its arrival, and its children.

    `dark`: the ray carries no light, and is followed for a derivative.
    """
    shapes = tables.shapes
    # Find the closest surface along each ray.
    primitive, crossing, entering, cut, outline = _meets(tables, ray, footprint, departure, needed)
    if footprint is None:
        hit = stage(needed, lambda *a: surface_at(shapes, *a), ray, primitive, crossing)
        direction, beam = ray.direction, None
    else:
        met = primitive, crossing, entering, cut, outline
        hit, direction, beam = arriving(shapes, ray, footprint, *met, departure, needed)
    # Find what lies on either side, for the indices.
    outside, inside = media(tables, plan, hit, dark)
    at = wrinkled(tables, arrival(hit, direction, outside, inside, beam), cone, needed)
    # Find what each light sees of the point, and which rays it sends on.
    seen = shadows_at(tables, plan, at, needed)
    nodes = Nodes(primitive, crossing, hit.entering, outside, inside, seen, cut, outline, origin)
    if not plan.branching:
        return nodes, at, None
    bent = at if not plan.effects.gloss else roughened(tables, plan, at, chances(plan, samples, origin, origin.level))
    return nodes, at, stage(needed, lambda *a: branches(tables, plan, *a), bent)


def _meets(tables: Tables, ray: Ray, footprint: Footprint | None, departure: Departure, needed):
    """The surface that each ray meets, its crossing and, where rays have a footprint, its side, whether its silhouette
    cuts the pixel, and where there are meshes which silhouette that is.
    """
    distance, primitive, crossing = stage(needed, lambda *a: nearest(tables.shapes, *a), ray, departure)
    if footprint is None:
        return *_in_order(tables, needed, ray, None, departure, primitive, crossing, None, None), None

    def near(ray, footprint, departure):
        return near_silhouettes(tables.shapes, ray, *footprint.reach()) | (departure.passed[0] >= 0)

    def side(ray, primitive, crossing):
        return surface_at(tables.shapes, ray, primitive, crossing).entering

    doubtful = stage(needed, near, ray, footprint, departure)
    entering = stage(needed, side, ray, primitive, crossing)
    whole = primitive, crossing, entering, jnp.zeros_like(entering)
    met = packed(doubtful, lambda *a: nearest_part(tables.shapes, *a), whole, ray, footprint, departure)
    met = _in_order(tables, needed, ray, footprint, departure, *met)
    if not tables.shapes.sides:
        return *met, None
    return divided(tables.shapes, ray, footprint, departure, distance, *met, needed)


def _in_order(tables: Tables, needed, ray: Ray, footprint: Footprint | None, departure: Departure, *met):
    """The same where surfaces lie in one place: the layer that comes first."""
    if tables.shapes.sheets is None:
        return met
    return stage(needed, lambda *a: in_order(tables.shapes, *a), ray, footprint, departure, *met)


def _append(lineage, count, parent, sends, alive):
    """Append the children of a block to the queue, packed; entries past the room are counted, not kept."""
    mirror, through, past = sends
    kinds = [((mirror > 0) & alive, mirror), (through & alive, TRANSMITTED)]
    if past is not None:
        kinds.append((past & alive, PAST))
    before, born = running_count(sum(there.astype(jnp.float32) for there, _ in kinds))
    place, past_the_end = count + before, lineage.shape[0]
    for there, branch in kinds:
        child = parent * BRANCHES + branch
        lineage = lineage.at[jnp.where(there, place, past_the_end)].set(child, mode="drop", unique_indices=True)
        place = place + there
    return lineage, count + born
