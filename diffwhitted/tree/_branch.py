"""From one node to its children: which rays it sends on, where they go, and what share they carry."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..geometry import Departure, Footprint, Ray, facing
from ..numerics._vector import Vec3, lookup, where
from ..optics import eta_at, mirrored, refracted, refraction_radicand
from ..scene import Tables
from ._arrival import MIRROR, PAST, TOTAL, TRANSMITTED, Arrival
from ._beam import child_beam, is_rim, radicand
from ._plan import Plan


def branches(
    tables: Tables, plan: Plan, at: Arrival
) -> tuple[Int[Array, "n"], Bool[Array, "n"], Bool[Array, "n"] | None]:
    """The mirror child (0 for none, else MIRROR or TOTAL), whether there is a transmitted one, and one that runs past."""
    there = at.object >= 0
    past = None if at.beam is None else there & (at.beam.edge.share < 1)
    mirror = jnp.where(there & _flags(plan.mirrors, at.object), jnp.int32(MIRROR), 0)
    if not plan.effects.refraction:
        return mirror, jnp.zeros_like(there), past
    through = there & _flags(plan.transparent, at.object)
    if plan.effects.total_internal_reflection:
        some, all = _total_reflection(tables, at)
        mirror = jnp.where(through & some, jnp.int32(TOTAL), mirror) if plan.total_reflection_is_full else mirror
        through = through & ~all
    return mirror, through, past


def child(tables: Tables, plan: Plan, at: Arrival, branch: Int[Array, "n"]) -> tuple[Ray, Footprint | None, Vec3]:
    """The ray that leaves a parent along a branch, its footprint, and the share of its light that the parent passes on."""
    factor, bend = share(tables, plan, at.object, branch), eta(tables, at) if plan.effects.refraction else None
    if at.beam is not None:
        return child_beam(tables, plan, at, branch, factor, bend)
    direction = (
        mirrored(at.direction, at.normal) if plan.effects.reflection or plan.effects.total_internal_reflection else None
    )
    if plan.effects.refraction:
        bent = refracted(at.direction, at.normal, bend)
        direction = bent if direction is None else where(branch == TRANSMITTED, bent, direction)
    return Ray(at.point, direction), None, factor


def departure(at: Arrival, branch: Int[Array, "n"]) -> Departure:
    """The side of the surface on which a child leaves, and what it is known to run past."""
    leaves = Departure(at.object, at.entering == (branch == TRANSMITTED))
    if at.beam is None:
        return leaves
    past, before = branch == PAST, at.beam.departure
    passed = (jnp.where(past, at.object, -1), *(jnp.where(past, one, -1) for one in before.passed[:-1]))
    return Departure(
        jnp.where(past, before.object, leaves.object), jnp.where(past, before.inwards, leaves.inwards), passed
    )


def share(tables: Tables, plan: Plan, object: Int[Array, "n"], branch: Int[Array, "n"]) -> Vec3:
    """What part of a child's light the parent passes on: k_s, k_t, or all of it (Whitted (2))."""
    material = lookup(tables.material_of, object)
    one = jnp.ones(branch.shape, tables.ambient.dtype)
    factor = Vec3(one, one, one)
    if plan.effects.reflection:
        factor = where(branch == MIRROR, lookup(tables.materials.k_s, material), factor)
    if plan.effects.refraction:
        factor = where(branch == TRANSMITTED, lookup(tables.materials.k_t, material), factor)
    return factor


def _total_reflection(tables: Tables, at: Arrival) -> tuple[Bool[Array, "n"], Bool[Array, "n"]]:
    """Where some of the light, and where all of it, is past the critical angle."""
    if at.beam is not None:
        square = radicand(at, eta(tables, at))
        rim, past = is_rim(square), square.value < 0
        return past | rim, past & ~rim
    past = refraction_radicand(facing(at.hit(), at.direction), eta(tables, at)) < 0
    return past, past


def eta(tables: Tables, at: Arrival) -> Float[Array, "n"]:
    """Index on the ray's side over the index on the far side."""
    index = tables.materials.refractive_index
    inside = lookup(index, lookup(tables.material_of, at.object))
    outside = jnp.ones_like(inside)
    if at.outside is not None:
        around = lookup(index, lookup(tables.material_of, jnp.maximum(at.outside, 0)))
        outside = jnp.where(at.outside >= 0, around, outside)
    return eta_at(at.entering, inside, outside)


def _flags(flags: tuple[bool, ...], object: Int[Array, "n"]) -> Bool[Array, "n"]:
    if all(flags):
        return jnp.ones(object.shape, bool)
    return lookup(jnp.asarray(flags), object)
