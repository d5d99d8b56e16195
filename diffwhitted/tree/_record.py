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
    NOTHING,
    Departure,
    Footprint,
    Ray,
    containing,
    hidden_parts,
    near_outlines,
    nearest,
    nearest_part,
    surface_at,
)
from ..illumination import before, sees_light, surfaces_crossed
from ..numerics._stage import empty_buffers, packed, running_count, stage, write_block
from ..numerics._vector import Vec3, where
from ..scene import Camera, Tables
from ._arrival import BRANCHES, PAST, TRANSMITTED, Arrival, Origin, arrival
from ._beam import arriving, light_beam
from ._branch import branches
from ._departure import any_ray, departing, parents_of, sides_of
from ._plan import Plan
from ._samples import Samples, Window
from ._truncation import Beyond, followed, left_out

MOST_SHADING = 1
"""So many objects may hide a light in part; further ones count whole or not at all."""
CROSSINGS = 2
"""A straight line meets no shape of this house more often."""


class Nodes(eqx.Module):
    """What is discrete about rays, one entry a ray."""

    object: Int[Array, "n"]
    """The object met; -1 for the background."""
    entering: Bool[Array, "n"]
    outside: Int[Array, "n"] | None
    """The solid around that object, where media are nested."""
    visible: tuple[Bool[Array, "n"], ...]
    """For each light: nothing opaque in between. Empty where nothing casts shadows."""
    crossed: tuple[tuple[Int[Array, "n"], ...], ...]
    """For each light and each transparent material: the surfaces in between."""
    cut: Bool[Array, "n"] | None
    """The outline of the object cuts the pixel; None where rays have no footprint."""
    shading: tuple[tuple[Int[Array, "n"], ...], ...]
    """For each light: the objects that hide part of it from the footprint, -1 for none."""
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


def record(tables: Tables, camera: Camera, plan: Plan, samples: Samples, window: Window | None = None) -> Record:
    """The tree of the samples of a pass, or of a window of them."""
    return follow(*jax.lax.stop_gradient((tables, camera)), plan, jax.lax.stop_gradient(samples), window=window)[0]


def follow(
    tables: Tables,
    camera: Camera,
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
    one = jnp.ones(plan.block, tables.ambient.dtype)
    white = Vec3(one, one, one)
    weighed, lit = light_of is not None or plan.effects.cutoff, light_of is not None and window is not None
    follow_rays = jax.jit(partial(_follow, tables, plan))  # traced once, for its shapes and for its results

    def waiting(state):
        start, (_, count) = state[0], state[2]
        return (start < jnp.minimum(count, room)) & ((window is None) | (count <= room))

    def follow_block(state):
        start, block, (lineage, count), (nodes, arrivals, throughputs), (starts, ends), film = state
        end = jnp.minimum(jnp.minimum(start + plan.block, count), room)
        slot = start + jnp.arange(plan.block, dtype=jnp.int32)
        origin = _origin(plan, nodes.origin, slot, lineage, cameras, window)
        alive = (slot < end) & samples.there[origin.sample]
        parents, throughput = parents_of(origin, (arrivals, throughputs)) if plan.branching else (None, white)
        ray, footprint, factor = departing(tables, camera, plan, samples, parents, origin, alive)
        sides = sides_of(plan, parents, origin)
        if weighed:
            throughput = where(origin.lineage == 0, white, throughput) * factor
        nodes_here, at, children = follow_rays(ray, footprint, sides, origin, alive.any())
        sends = followed(tables, plan, at, origin.level, throughput, children, lit) if plan.branching else None
        queue = _append(lineage, count, slot, sends, alive) if plan.branching else (lineage, count)
        lost = left_out(tables, plan, beyond, at, throughput, children, sends) if beyond and plan.branching else None
        light = tuple(throughput * part for part in light_of(nodes_here, ray, at, alive.any())) if light_of else None
        seen = light, lost
        film = jax.tree.map(lambda f, a: f.at[origin.sample].add(jnp.where(alive, a, 0)), film, seen)
        buffers = write_block((nodes, arrivals, throughputs), (nodes_here, at, throughput if weighed else None), start)
        return end, block + 1, queue, buffers, (starts.at[block].set(start), ends.at[block].set(end)), film

    shapes = jax.eval_shape(follow_rays, *any_ray(plan, one.dtype), jnp.bool_(True))[:2]
    buffers = empty_buffers((*shapes, white if weighed else None), plan.slots)
    queue, bounds = ((jnp.zeros(plan.slots, jnp.int32), jnp.int32(cameras)), jnp.full(plan.blocks, room, jnp.int32))
    film = empty_buffers(
        ((white,) * kinds if light_of else None, white if beyond and plan.branching else None), plan.pass_pixels
    )
    first = (jnp.int32(0), jnp.int32(0), queue, buffers, (bounds, bounds), film)
    _, _, (_, count), (nodes, *_), (starts, ends), film = jax.lax.while_loop(waiting, follow_block, first)
    return Record(nodes, starts, ends, count - cameras), film


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
    tables: Tables, plan: Plan, ray: Ray, footprint: Footprint | None, departure: Departure, origin: Origin, needed
):
    """Find the surface that each ray meets: its node, its arrival, and its children."""
    object, entering, cut = _meets(tables, ray, footprint, departure, needed)
    if footprint is None:
        hit, direction, beam = (
            stage(needed, lambda *a: surface_at(tables.shapes, *a), ray, object, entering),
            ray.direction,
            None,
        )
    else:
        hit, direction, beam = arriving(tables.shapes, ray, footprint, object, entering, cut, departure, needed)
    outside = containing(tables.shapes, hit.point, plan.solids, but=object) if plan.effects.nested_media else None
    at = arrival(hit, direction, outside, beam)
    visible, crossed, shading = _shadows(tables, plan, at, needed)
    nodes = Nodes(object, entering, outside, visible, crossed, cut, shading, origin)
    if not plan.branching:
        return nodes, at, None
    return nodes, at, stage(needed, lambda *a: branches(tables, plan, *a), at)


def _meets(tables: Tables, ray: Ray, footprint: Footprint | None, departure: Departure, needed):
    """The object that each ray meets, its side, and whether its outline cuts the pixel."""
    _, object, entering = stage(needed, lambda *a: nearest(tables.shapes, *a), ray, departure)
    if footprint is None:
        return object, entering, None

    def near(ray, footprint, departure):
        return near_outlines(tables.shapes, ray, *footprint.reach()) | (departure.passed[0] >= 0)

    doubtful = stage(needed, near, ray, footprint, departure)
    whole = object, entering, jnp.zeros_like(entering)
    return packed(doubtful, lambda *a: nearest_part(tables.shapes, *a), whole, ray, footprint, departure)


def _shadows(tables: Tables, plan: Plan, at: Arrival, needed):
    """What each light sees of the points."""
    if not plan.effects.shadows:
        return (), (), ()
    visible, crossed, shading = [], [], []
    opaque = tuple(not (plan.effects.tinted_shadows and glass) for glass in plan.transparent)
    # The shading normal faces the eye, so a lit point sees its light on the side that the ray came from.
    departure = Departure(at.object, ~at.entering)
    for light in tables.lights:
        to_light, distance, _ = stage(needed, light.arriving, at.point)
        ray, parts = Ray(at.point, to_light), ()
        sees = stage(needed, lambda *a: sees_light(tables.shapes, *a, opaque), ray, departure, distance)
        if at.beam is not None:
            sees, parts = _hidden(tables, light, ray, at.beam.footprint, departure, distance, opaque, sees, needed)
            shading.append(parts)
        visible.append(sees)
        if plan.effects.tinted_shadows:
            crossed.append(
                tuple(
                    surfaces_crossed(tables.shapes, ray, departure, distance, objects, parts).astype(
                        _count_type(objects)
                    )
                    for objects in glass_by_material(plan).values()
                )
            )
    return tuple(visible), tuple(crossed), tuple(shading)


def _hidden(
    tables: Tables,
    light,
    ray: Ray,
    footprint: Footprint,
    departure: Departure,
    distance,
    opaque: tuple[bool, ...],
    sees,
    needed,
):
    """Does some of the footprint see the light past all that hides it from the whole of it, and which objects hide it in part?"""

    def near(ray, footprint):
        return near_outlines(tables.shapes, ray, footprint.reach()[0], 0.0)

    def look(ray, footprint, departure, distance):
        beam = light_beam(light, ray.origin, footprint)
        hidden, parts = hidden_parts(tables.shapes, ray, beam, departure, before(distance), opaque, MOST_SHADING)
        return ~hidden, parts

    nobody = jnp.full(sees.shape, NOTHING, jnp.int32)
    doubtful = stage(needed, near, ray, footprint)
    return packed(doubtful, look, (sees, (nobody,) * MOST_SHADING), ray, footprint, departure, distance)


def _count_type(objects: tuple[bool, ...]):
    return jnp.int8 if most_crossed(objects) < 128 else jnp.int32


def most_crossed(objects: tuple[bool, ...]) -> int:
    """How many surfaces of these objects a straight line can cross."""
    return CROSSINGS * sum(objects)


def glass_by_material(plan: Plan) -> dict[int, tuple[bool, ...]]:
    """The transparent materials, each with the objects made of it."""
    materials = sorted({m for m, glass in zip(plan.material_of, plan.transparent, strict=True) if glass})
    return {m: tuple(g and n == m for n, g in zip(plan.material_of, plan.transparent, strict=True)) for m in materials}


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
