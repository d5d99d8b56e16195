"""What each light sees of the points where rays arrive: recorded once, without derivatives.

Lights of one structure are stacked (see `Tables.lights`); a loop over them asks one after the other, so that many
lights make no larger program than two.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..geometry import (
    NOTHING,
    Departure,
    Ray,
    hidden_by_layers,
    hidden_parts,
    layers_crossed,
    near_silhouettes,
    shaded_side,
)  # fmt: skip
from ..illumination import ball_beam, before, glass_crossed, light_footprint, sees_light
from ..numerics._safe import safe_divide
from ..numerics._stage import packed, stage
from ..numerics._vector import dot, lookup
from ..records import member, member_count
from ..scene import AbstractLight, Tables
from ._arrival import Arrival
from ._plan import Plan

MOST_SHADING = 1
"""So many surfaces may occlude a light in part; further ones count whole or not at all."""
MOST_SOFT = 4
"""The same of a ball of light that one ray looks at."""

TURNED = 0.1
"""Cosine of the angle between a light and the surface behind which no part of a footprint is lit any more."""


class Seen(eqx.Module):
    """What a group of lights sees of points; the first axis of each array is that of the lights, where there is one."""

    visible: Bool[Array, "*lights n"]
    """Nothing that blocks light in between."""
    crossed: tuple[Int[Array, "*lights n"], ...]
    """For each transparent material: its surfaces in between, where shadows are tinted."""
    shading: tuple[Int[Array, "*lights n"], ...]
    """The surfaces that occlude part of the light from the footprint, or part of a ball of light, -1 for none."""


def shadows_at(tables: Tables, plan: Plan, at: Arrival, needed) -> tuple[Seen, ...]:
    """What each group of lights sees of the points; empty where nothing casts shadows."""
    if not plan.effects.shadows:
        return ()
    blocks = blocking(tables) if plan.effects.tinted_shadows else None
    return tuple(
        for_lights(lights, lambda light, _: _seen(tables, plan, at, light, blocks, needed), ())
        for lights in tables.lights
    )


def blocking(tables: Tables) -> Bool[Array, "surfaces"]:
    """Which surfaces block light where shadows are tinted by glass."""
    return tables.shapes.by_surface(~lookup(tables.transparent, tables.material_of))


def for_lights(lights: AbstractLight, ask: Callable, inputs):
    """`ask(light, input)` for each of the stacked lights and of the inputs, its answers stacked in the same way."""
    if member_count(lights) == 1:
        answer = ask(member(lights, 0), jax.tree.map(lambda a: a[0], inputs))
        return jax.tree.map(lambda a: a[None], answer)
    return jax.lax.scan(lambda _, one: (None, ask(*one)), None, (lights, inputs))[1]


def _seen(tables: Tables, plan: Plan, at: Arrival, light: AbstractLight, blocks, needed) -> Seen:
    """What one light sees."""
    origin, departure = at.lit_from
    to_light, distance, _ = stage(needed, light.arriving, origin)
    ray, parts = Ray(origin, to_light), ()
    # Leave out points that are turned away from the light, where each search of a ray takes its time.
    searched = any(boxes is not None for boxes in tables.shapes.boxes)
    if searched and (at.beam is None or tables.shapes.sides):
        distance = jnp.where(dot(at.shading_normal, to_light) > (0 if at.beam is None else -TURNED), distance, 0)
    # Ask whether something blocks the way to the light.
    sees = stage(needed, lambda *a: sees_light(tables.shapes, *a, blocks), ray, departure, distance)
    hard = sees
    if at.beam is not None:
        sees, parts = _in_part(tables, light, ray, at, departure, distance, blocks, hard, needed)
        sees, parts = _past_meshes(tables, plan, light, ray, at, departure, distance, blocks, sees, parts, needed)
    if _is_soft(plan, light):
        more, others = _of_ball(tables, light, ray, departure, distance, blocks, hard, needed)
        sees, parts = (more if at.beam is None else sees | more), (*parts, *others)
    # Count the surfaces of glass on the way.
    crossed, count = (), tables.marks.glass.shape[0]
    if plan.effects.tinted_shadows:
        crossed = glass_crossed(tables.shapes, ray, departure, distance, tables.glass_of, count, parts)
    # Add what lies on the point itself.
    if tables.shapes.sheets is not None:
        sees = sees & ~hidden_by_layers(tables.shapes, at.point, departure, blocks)
        if plan.effects.tinted_shadows:
            upon = layers_crossed(tables.shapes, at.point, departure, tables.glass_of, count)
            crossed = tuple(one + more.astype(one.dtype) for one, more in zip(crossed, upon, strict=True))
    return Seen(sees, crossed, parts)


def _of_ball(tables: Tables, light: AbstractLight, ray: Ray, departure: Departure, distance, blocks, sees, needed):
    """Is some of a ball of light seen past all that hides the whole of it, and which surfaces hide part of it?"""
    shapes, size = tables.shapes, safe_divide(light.ball_radius(), distance)

    def near(ray, size):
        return near_silhouettes(shapes, ray, jnp.zeros_like(size), 2**0.5 * size)

    def look(ray, size, departure, distance):
        beam = ball_beam(ray, size)
        hidden, parts = hidden_parts(shapes, ray, beam, departure, before(distance), blocks, MOST_SOFT)
        return ~hidden, parts

    nobody = jnp.full(sees.shape, NOTHING, jnp.int32)
    doubtful = stage(needed, near, ray, size)
    return packed(doubtful, look, (sees, (nobody,) * MOST_SOFT), ray, size, departure, distance)


def _is_soft(plan: Plan, light: AbstractLight) -> bool:
    """Is it a ball of light that one ray looks at?"""
    return plan.effects.soft_shadows and light.ball_radius() is not None


def _past_meshes(
    tables: Tables,
    plan: Plan,
    light: AbstractLight,
    ray: Ray,
    at: Arrival,
    departure: Departure,
    distance,
    blocks,
    sees,
    parts,
    needed,
):
    """The same with meshes, whose outlines run along their sides; those before a ball of light hide it whole."""
    if not tables.shapes.sides or _is_soft(plan, light):
        return sees, parts
    beam = stage(needed, lambda *a: light_footprint(light, *a), ray.origin, at.beam.footprint)
    way = before(distance)
    sees, side = shaded_side(tables.shapes, ray, beam, departure, way, blocks, sees, parts[0], needed)
    return sees, (side, *parts[1:])


def _in_part(
    tables: Tables, light: AbstractLight, ray: Ray, at: Arrival, departure: Departure, distance, blocks, sees, needed
):
    """Does some of the footprint see the light past all that occludes the whole of it, and which surfaces occlude it
    in part?
    """
    shapes, footprint = tables.shapes, at.beam.footprint

    def near(ray, footprint):
        return near_silhouettes(shapes, ray, footprint.reach()[0], 0.0)

    def look(ray, footprint, departure, distance):
        beam = light_footprint(light, ray.origin, footprint)
        hidden, parts = hidden_parts(shapes, ray, beam, departure, before(distance), blocks, MOST_SHADING)
        return ~hidden, parts

    nobody = jnp.full(sees.shape, NOTHING, jnp.int32)
    doubtful = stage(needed, near, ray, footprint)
    return packed(doubtful, look, (sees, (nobody,) * MOST_SHADING), ray, footprint, departure, distance)
