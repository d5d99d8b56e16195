"""From one node to its children: which rays it sends on, and where they go."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..geometry import Departure, Footprint, Ray, on_its_side
from ..numerics._vector import Vec3, dot, lookup, where
from ..optics import mirrored, refracted, refraction_radicand, sine_squared
from ..scene import Tables
from ._arrival import MIRROR, PAST, TOTAL, TRANSMITTED, Arrival
from ._beam import child_beam, is_rim, radicand
from ._made_of import indices, material_at
from ._plan import Plan
from ._weights import weighed_point, weight


def branches(
    tables: Tables, plan: Plan, at: Arrival
) -> tuple[Int[Array, "n"], Bool[Array, "n"], Bool[Array, "n"] | None]:
    """The mirror child (0 for none, else MIRROR or TOTAL), whether there is a transmitted one, and one that runs
    past.
    """
    there, material = at.object >= 0, material_at(tables, at.object)
    past = None if at.beam is None else there & (at.beam.edge.coverage < 1)
    mirror = jnp.zeros(there.shape, jnp.int32)
    if plan.effects.reflection:
        mirror = jnp.where(there & lookup(tables.mirrors, material), jnp.int32(MIRROR), mirror)
    if not plan.effects.refraction:
        return mirror, jnp.zeros_like(there), past
    through = there & lookup(tables.transparent, material)
    if plan.effects.total_internal_reflection:
        some, all = _total_reflection(tables, at)
        if plan.total_reflection_is_full:
            mirror = jnp.where(through & lookup(tables.clear, material) & some, jnp.int32(TOTAL), mirror)
        through = through & ~all
    return mirror, through, past


def child(
    tables: Tables, plan: Plan, at: Arrival, branch: Int[Array, "n"], needed
) -> tuple[Ray, Footprint | None, Vec3]:
    """The ray that leaves a parent along a branch, its footprint, and the part of its light that the parent passes
    on.
    """
    point = weighed_point(tables, plan, at, needed)
    factor, bend = weight(plan, point, branch), point.eta if plan.effects.refraction else None
    if at.beam is not None:
        return child_beam(plan, at, point, branch, factor, bend)
    bounces = plan.effects.reflection or plan.effects.total_internal_reflection
    direction = mirrored(at.direction, at.shading_normal) if bounces else None
    if plan.effects.refraction:
        bent = refracted(at.direction, at.shading_normal, bend)
        direction = bent if direction is None else where(branch == TRANSMITTED, bent, direction)
    if at.lifted is not None or plan.effects.gloss or plan.effects.wrinkles:
        direction = on_its_side(direction, at.normal, branch == TRANSMITTED)
    return Ray(at.point if at.start is None else at.start, direction), None, factor


def departure(at: Arrival, branch: Int[Array, "n"]) -> Departure:
    """The side of the surface on which a child leaves, and what it is known to run past."""
    leaves = Departure(at.primitive, at.entering == (branch == TRANSMITTED))
    if at.beam is None:
        return leaves
    past, before = branch == PAST, at.beam.departure
    outline = at.primitive if at.beam.outline is None else at.beam.outline
    passed = (jnp.where(past, outline, -1), *(jnp.where(past, one, -1) for one in before.passed[:-1]))
    return Departure(
        jnp.where(past, before.primitive, leaves.primitive), jnp.where(past, before.inwards, leaves.inwards), passed
    )


def eta(tables: Tables, at: Arrival) -> Float[Array, "n"]:
    """Index on the ray's side over the index on the far side."""
    here, beyond = indices(tables, at)
    return here / beyond


def _total_reflection(tables: Tables, at: Arrival) -> tuple[Bool[Array, "n"], Bool[Array, "n"]]:
    """Where some of the light, and where all of it, is past the critical angle."""
    if at.beam is not None:
        square = radicand(at, eta(tables, at))
        rim, past = is_rim(square), square.value < 0
        return past | rim, past & ~rim
    bend = eta(tables, at)
    sine = sine_squared(at.direction, at.shading_normal, bend)
    past = refraction_radicand(-dot(at.shading_normal, at.direction), bend, sine) < 0
    return past, past
