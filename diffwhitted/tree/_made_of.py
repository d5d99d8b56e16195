"""What a point is made of: coefficients with their textures, both normals, the indices on both sides, the footprint."""

from collections.abc import Sequence
from functools import reduce
from operator import mul

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..geometry import NOTHING
from ..illumination import SurfacePoint
from ..numerics._safe import safe_divide
from ..numerics._stage import packed, stage
from ..numerics._vector import Vec3, dot, lookup, where
from ..records import member_count
from ..scene import CHOICES, Tables
from ..scene.textures import AbstractTexture, TexturePoint
from ._arrival import Arrival
from ._effects import effect_rows
from ._plan import Plan

STEEPEST = 1.6
"""Slant beyond which a footprint that runs to the horizon is cut off: at 2 its far end is infinitely far away."""


def made_of(tables: Tables, plan: Plan, at: Arrival, needed, names: Sequence[str]) -> SurfacePoint:
    """The point where rays arrived, with those of its coefficients that are named.

    `needed`: whether any ray of the block is alive (see `stage`).
    """
    # Look up the coefficients of each point's material.
    material = material_at(tables, at.object)
    coefficients = {name: lookup(tables.coefficients[name], material) for name in names}
    # Multiply them by their textures, each pattern computed once.
    for group in plan.textured if plan.effects.textures else ():
        worn = [name for name in group if name in coefficients]
        if worn:
            pattern = _pattern(tables, lookup(tables.texture_of[group[0]], material), at, needed)
            for name in worn:
                coefficients[name] = coefficients[name] * pattern
    chosen = plan.effects.choices(plan.highlight_models)
    here, beyond = indices(tables, at) if plan.effects.indices else (None, None)
    return SurfacePoint(
        there=at.object >= 0,
        position=at.point,
        normal=at.normal,
        shading_normal=at.shading_normal,
        incoming=at.direction,
        distance=at.distance,
        entering=at.entering,
        material=material,
        models={name: lookup(tables.models[list(CHOICES).index(name)], material) for name in chosen},
        coefficients=coefficients,
        index_here=here,
        index_beyond=beyond,
        footprint=None if at.beam is None else at.beam.footprint,
        curvature=None if at.beam is None else at.beam.curvature,
        uv=at.uv,
        bent=at.bent,
        left=_left_of_light(tables, plan, at.distance),
    )


def place_at_rest(tables: Tables, at: Arrival) -> Vec3:
    """Where the points are while nothing moves: patterns go along with what they are on."""
    if tables.shift is None:
        return at.point
    return at.point - lookup(tables.shift, jnp.maximum(at.object, 0))


def material_at(tables: Tables, object: Int[Array, "n"]) -> Int[Array, "n"]:
    """The number of the material of each object; of no meaning for -1."""
    return lookup(tables.material_of, object)


def indices(tables: Tables, at: Arrival) -> tuple[Float[Array, "n"], Float[Array, "n"]]:
    """The refractive index on the ray's side of the surface, and the one on the far side."""
    index = tables.coefficients["refractive_index"]
    inside = lookup(index, material_at(tables, at.object)) if at.inside is None else index_of(tables, at.inside)
    outside = jnp.ones_like(inside) if at.outside is None else index_of(tables, at.outside)
    return jnp.where(at.entering, outside, inside), jnp.where(at.entering, inside, outside)


def sides(at: Arrival) -> tuple[Int[Array, "n"], Int[Array, "n"]]:
    """The object in which the ray travelled, -1 for none, and the one on the far side of the surface."""
    inside = at.object if at.inside is None else at.inside
    outside = jnp.full_like(inside, NOTHING) if at.outside is None else at.outside
    return jnp.where(at.entering, outside, inside), jnp.where(at.entering, inside, outside)


def index_of(tables: Tables, object: Int[Array, "n"]) -> Float[Array, "n"]:
    """The refractive index of each object; 1 for -1."""
    index = lookup(tables.coefficients["refractive_index"], material_at(tables, jnp.maximum(object, 0)))
    return jnp.where(object >= 0, index, 1)


def _left_of_light(tables: Tables, plan: Plan, distance: Float[Array, "n"]) -> Float[Array, "n"] | None:
    """What effects leave of light along rays of these lengths; None: all of it."""
    left = [row.dims(tables, distance) for row in effect_rows() if row.dims is not None and row.name in plan.effects]
    return reduce(mul, left) if left else None


def slant(at: Arrival) -> tuple[Float[Array, "n"], ...]:
    """Perspective: on a flat surface the point is at (dP_u u + dP_v v) / (1 + slant_u u + slant_v v); 0 on others."""
    flat, towards = at.beam.curvature == 0, dot(at.direction, at.normal)
    return tuple(
        jnp.clip(jnp.where(flat, safe_divide(dot(side.direction, at.normal), towards), 0), -STEEPEST, STEEPEST)
        for side in at.beam.footprint.sides()
    )


def _pattern(tables: Tables, number: Int[Array, "n"], at: Arrival, needed) -> Vec3:
    """The colour of the numbered texture at each point, or its mean over the footprint; white for -1."""
    one = jnp.ones_like(at.point.x)
    pattern, first = Vec3(one, one, one), 0
    for group in tables.textures:
        worn = (number >= first) & (number < first + member_count(group)) & (at.object >= 0)
        pattern = where(worn, _coloured(tables, group, jnp.where(worn, number - first, 0), worn, at, needed), pattern)
        first += member_count(group)
    return pattern


def _coloured(tables: Tables, group: AbstractTexture, which: Int[Array, "n"], worn, at: Arrival, needed) -> Vec3:
    """The colour of textures of one structure, where they are `worn`."""
    point = TexturePoint(place_at_rest(tables, at), at.shading_normal, at.uv)
    if at.beam is None or not group.FOOTPRINT:
        return group.chosen(which).at(point)
    steps = _steps(at)
    slants = stage(needed, slant, at)
    some, much = stage(needed, lambda which, *a: group.chosen(which).varies(*a), which, point, steps, slants)
    plain = group.chosen(which).at(point)
    colour = packed(some & worn, lambda which, *a: group.chosen(which).mean(*a), plain, which, point, steps)
    return packed(
        much & worn, lambda which, *a: group.chosen(which).mean_in_perspective(*a), colour, which, point, steps, slants
    )


def _steps(at: Arrival) -> tuple[TexturePoint, ...]:
    """How what a texture is asked about changes along the sides of the pixel; uv by `uv_steps`, or not at all."""
    level = None if at.uv is None else tuple(map(jnp.zeros_like, at.uv))
    return tuple(
        TexturePoint(side.origin, side.origin * at.beam.curvature, level if at.beam.uv_steps is None else uv)
        for side, uv in zip(at.beam.footprint.sides(), at.beam.uv_steps or (None, None), strict=True)
    )
