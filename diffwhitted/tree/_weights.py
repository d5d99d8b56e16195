"""What part of a child's light its parent passes on.

The mirror ray carries k_s, the transmitted one k_t, and the ray of total internal reflection all of it (Whitted (2)).
An effect that changes this (see `_effects`) knows the whole point: the angle of incidence, the way that the light has
come, the indices on both sides.
"""

from dataclasses import replace

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..illumination import SurfacePoint
from ..numerics._vector import Vec3, where
from ..scene import Tables
from ._arrival import MIRROR, PAST, TOTAL, TRANSMITTED, Arrival
from ._effects import effect_rows
from ._made_of import made_of
from ._plan import Plan

WEIGHED_BY = ("k_s", "k_t", "refractive_index")
"""The coefficients that weights hang on, beside those that an effect adds."""


def weighed_point(tables: Tables, plan: Plan, at: Arrival, needed) -> SurfacePoint:
    """The point with all that the weights of its branches hang on."""
    return made_of(tables, plan, at, needed, (*WEIGHED_BY, *plan.weighed_by))


def weight(plan: Plan, point: SurfacePoint, branch: Int[Array, "n"]) -> Vec3:
    """The weight of a branch of each point, linear RGB; 1 for camera rays and for those that run past a silhouette.

    What effects take of light on the way from the point to where its own ray came from is taken from its branches too.
    """
    one = jnp.ones(branch.shape, point.position.dtype)
    factor = Vec3(one, one, one)
    if plan.effects.reflection:
        factor = where(branch == MIRROR, point.coefficients["k_s"], factor)
    if plan.effects.refraction:
        factor = where(branch == TRANSMITTED, point.coefficients["k_t"], factor)
    for effect in effect_rows():
        if effect.weighs is not None and effect.name in plan.effects:
            factor = effect.weighs(point, branch, factor)
    return factor if point.left is None else factor * jnp.where(branch == PAST, 1, point.left)


def weight_at_rim(
    plan: Plan, point: SurfacePoint, branch: Int[Array, "n"], before: Float[Array, "n"], radicand: Float[Array, "n"]
) -> Vec3:
    """The weight where total internal reflection begins within the pixel, `before` of which lies before it, and where
    cos_r**2 is `radicand` in the mean.

    What is transmitted comes from there alone. The mirror ray of the light before the rim goes along with what is
    totally reflected.
    """
    part = replace(point, mean_radicand=radicand)
    factor = weight(plan, part, branch)
    factor = where(branch == TRANSMITTED, factor * before, factor)
    if not plan.total_reflection_is_full:
        return factor
    past = factor * (1 - before)
    if plan.effects.reflection:
        past = past + weight(plan, part, jnp.full_like(branch, MIRROR)) * before
    return where(branch == TOTAL, past, factor)
