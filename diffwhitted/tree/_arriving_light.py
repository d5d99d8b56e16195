"""How much of a light arrives at a point: past what occludes it, and through the glass on the way."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Int

from ..geometry import Ray, silhouette_of
from ..illumination import SurfacePoint, count_bits, light_footprint, seen_of_ball, tint
from ..numerics._coverage import coverage
from ..numerics._safe import safe_divide
from ..numerics._stage import packed
from ..numerics._vector import Vec3, lookup, where
from ..scene import AbstractLight, Tables
from ._absorption import left_on_the_way_to
from ._arrival import Arrival
from ._made_of import material_at
from ._plan import Plan
from ._shadows import Seen


def arriving_part(
    tables: Tables,
    plan: Plan,
    light: AbstractLight,
    seen: Seen | None,
    at: Arrival,
    point: SurfacePoint,
    to_light: Vec3,
    needed,
):
    """s_j of Parker et al. (1): 0 or 1, times k_t for each transparent surface on the way where shadows are tinted, and
    what the glass between them absorbs.
    Where rays have a footprint, the part of it that sees the light.

    `seen`: what this light sees of the points; None where nothing casts shadows.
    """
    if seen is None:
        return 1
    visible = seen.visible.astype(point.position.dtype)
    part = Vec3(visible, visible, visible) if plan.effects.tinted_shadows else visible
    if plan.effects.tinted_shadows:
        part = part * _through_glass(tables, seen)
        if plan.effects.absorption:
            part = part * left_on_the_way_to(tables, plan, at, light, needed)
    return part * _past_silhouettes(tables, plan, light, seen, at, point, to_light)


def _through_glass(tables: Tables, seen: Seen) -> Vec3:
    """k_t for each surface crossed, material by material."""
    k_t, bits, part = tables.coefficients["k_t"], count_bits(tables.shapes), None
    for material, crossed in zip(tables.marks.glass, seen.crossed, strict=True):
        of_it = jax.tree.map(lambda column, m=material: column[jnp.maximum(m, 0)], k_t)
        passed = tint(of_it, crossed.astype(jnp.int32), bits)
        part = passed if part is None else part * passed
    return part


def _past_silhouettes(
    tables: Tables, plan: Plan, light: AbstractLight, seen: Seen, at: Arrival, point: SurfacePoint, to_light: Vec3
):
    """What comes past the surfaces that occlude the light from part of the footprint."""
    one = jnp.ones_like(point.position.x)
    through = whole = Vec3(one, one, one) if plan.effects.tinted_shadows else one

    def look(position, to_light, footprint, occluder):
        beam = light_footprint(light, position, footprint)
        silhouette = silhouette_of(tables.shapes, Ray(position, to_light), beam, occluder)
        return _past(tables, plan, occluder, coverage(-silhouette))

    def look_at_ball(position, to_light, footprint, occluder):
        pixel = None if footprint is None else light_footprint(light, position, footprint)
        size = safe_divide(light.ball_radius(), light.arriving(position)[1])
        return _past(
            tables, plan, occluder, seen_of_ball(tables.shapes, Ray(position, to_light), size, pixel, occluder)
        )

    soft = plan.effects.soft_shadows and light.ball_radius() is not None
    for occluder in seen.shading:
        way = at.lit_from[0], to_light, point.footprint, occluder
        passed = packed(occluder >= 0, look_at_ball if soft else look, whole, *way)
        # Of a ball the one that hides most of it counts; parts of a footprint are hidden one by one.
        through = jax.tree.map(jnp.minimum, through, passed) if soft else through * passed
    return through


def _past(tables: Tables, plan: Plan, occluder: Int[Array, "n"], free):
    """What comes past a surface: what its silhouette leaves free, and what tinted glass lets through of the rest."""
    if not plan.effects.tinted_shadows:
        return free
    occluder = tables.shapes.named(occluder)
    object = tables.shapes.object_at(occluder)
    material = material_at(tables, object)
    k_t = lookup(tables.coefficients["k_t"], material)
    solid = jnp.concatenate([jnp.full(family.count, family.SOLID) for family in tables.shapes.families])
    glass = lookup(tables.transparent, material)
    zero = jnp.zeros_like(free)
    through = where(glass, where(lookup(solid, occluder), k_t * k_t, k_t), Vec3(zero, zero, zero))
    return through * (1 - free) + Vec3(free, free, free)
