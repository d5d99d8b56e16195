"""From one node to its children: which rays it sends on, where they go, and what share they carry."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._vector import Vec3, lookup, where
from ..geometry import Departure, Hit, Ray, facing
from ..optics import eta_at, mirrored, refracted, refraction_radicand
from ..scene import Tables
from ._plan import Plan

CAMERA, MIRROR, TRANSMITTED, TOTAL = range(4)
"""The branches of the tree: a camera ray, the mirror ray weighted by k_s, the transmitted ray weighted by
k_t, and the mirror ray of total internal reflection, which carries everything."""

BRANCH_NAMES = ("camera", "mirror", "transmitted", "total")


class Origin(eqx.Module):
    """Where rays come from in the tree."""

    pixel: Int[Array, "n"]
    """Which pixel of the pass the ray belongs to."""
    level: Int[Array, "n"]
    """1 for a camera ray."""
    lineage: Int[Array, "n"]
    """4 * parent + branch, the parent by the number of its node."""


class Arrival(eqx.Module):
    """How a ray arrived at its surface: all that its children start from."""

    point: Vec3
    normal: Vec3
    direction: Vec3
    object: Int[Array, "n"]
    entering: Bool[Array, "n"]
    outside: Int[Array, "n"] | None
    """The solid around the object, -1 for none; None where the plan knows no nested media."""


def arrival(hit: Hit, direction: Vec3, outside) -> Arrival:
    return Arrival(hit.point, hit.normal, direction, hit.object, hit.entering, outside)


def branches(tables: Tables, plan: Plan, at: Arrival, hit: Hit) -> tuple[Int[Array, "n"], Bool[Array, "n"]]:
    """The mirror child (0 for none, else MIRROR or TOTAL) and whether there is a transmitted child."""
    there = at.object >= 0
    mirror = jnp.where(there & _flags(plan.mirrors, at.object), jnp.int32(MIRROR), 0)
    if not plan.effects.refraction:
        return mirror, jnp.zeros_like(there)
    through = there & _flags(plan.transparent, at.object)
    if plan.effects.total_internal_reflection:
        total = through & (refraction_radicand(facing(hit, at.direction), _eta(tables, at)) < 0)
        through = through & ~total
        if plan.total_reflection_is_full:
            mirror = jnp.where(total, jnp.int32(TOTAL), mirror)
    return mirror, through


def child_ray(tables: Tables, plan: Plan, at: Arrival, branch: Int[Array, "n"]) -> tuple[Ray, Departure]:
    """The ray that leaves a parent along a branch, and the side of the surface it leaves on."""
    direction = mirrored(at.direction, at.normal) if plan.effects.reflection or plan.effects.total_internal_reflection else None
    through = branch == TRANSMITTED
    if plan.effects.refraction:
        bent = refracted(at.direction, at.normal, _eta(tables, at))
        direction = bent if direction is None else where(through, bent, direction)
    return Ray(at.point, direction), Departure(at.object, at.entering == through)


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


def _eta(tables: Tables, at: Arrival) -> Float[Array, "n"]:
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
