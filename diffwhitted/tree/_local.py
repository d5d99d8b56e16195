"""The light that a node adds itself: what its surface sends back of ambient light and lamps.

I = k_a I_a + sum over lights of s_j I_j (k_d (N.L_j) + k_h (highlight)), Parker et al. (1). The highlight
has no factor N.L. Only the terms that the plan's effects name are computed.
"""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp

from ..illumination import SurfacePoint, light_terms, within_borders
from ..numerics._stage import stage
from ..numerics._vector import Vec3
from ..records import member, member_count
from ..scene import AbstractLight, Hemisphere, Tables
from ._arrival import Arrival
from ._arriving_light import arriving_part
from ._effects import effect_rows
from ._interpolation import Interpolation, interpolation
from ._made_of import made_of
from ._plan import Plan
from ._record import Nodes
from ._shadows import Seen


def local_radiance(tables: Tables, plan: Plan, nodes: Nodes, at: Arrival, needed) -> Vec3:
    """Linear RGB that leaves the surface towards where the ray came from; of no meaning for a miss.

    `needed`: whether any ray of the block is alive (see `stage`). Where rays have a footprint it is the mean over it.
    """
    effects = plan.effects
    adding = [row for row in effect_rows() if row.adds is not None and row.name in effects]
    highlight = "k_h", "phong_exponent"
    named = {
        "ambient": ("k_a",), "diffuse": ("k_d",), "highlight": highlight, "environment": ("k_d",),
        "environment_highlight": highlight, "radiosity": ("k_d",),
    }  # fmt: skip
    names = [name for effect, some in named.items() if effect in effects for name in some]
    point = made_of(tables, plan, at, needed, (*names, *(name for row in adding for name in row.coefficients)))
    if effects.environment or effects.environment_highlight:
        point = replace(point, surroundings=tables.surroundings)
    if effects.radiosity and tables.lightmap is not None:
        found = stage(needed, tables.lightmap.at, at.primitive, nodes.crossing, at.entering, at.point)
        point = replace(point, gathered=found)
    for row in effect_rows():
        if row.at_points is not None and row.name in effects:
            point = replace(point, coefficients=point.coefficients | row.at_points(point))
    black = jnp.zeros_like(at.point.x)
    radiance = Vec3(black, black, black)
    # Add what the surface sends back of ambient light, and what effects add.
    if effects.ambient:
        ambient = tables.ambient
        radiance = radiance + point.coefficients["k_a"] * (
            ambient.at(point.shading_normal) if isinstance(ambient, Hemisphere) else ambient
        )
    for row in adding:
        radiance = radiance + row.adds(point)
    point = replace(point, surroundings=None, gathered=None)
    radiance = _of_lights(tables, plan, nodes, at, point, radiance, needed) if effects.lighting else radiance
    return radiance if point.left is None else radiance * point.left


def _of_lights(
    tables: Tables, plan: Plan, nodes: Nodes, at: Arrival, point: SurfacePoint, radiance: Vec3, needed
) -> Vec3:
    """The radiance and what the points send back of each light; a loop takes the lights of one structure one after the
    other.
    """
    # Look for what interpolates light over triangles.
    smooth = plan.effects.gouraud or plan.effects.fast_phong
    between = interpolation(tables, plan, at) if smooth else None
    point = point if between is None else between.seen_by_lights(point)
    for number, lights in enumerate(tables.lights):
        seen = nodes.seen[number] if plan.effects.shadows else None
        if member_count(lights) == 1:
            light, of_it = member(lights, 0), jax.tree.map(lambda a: a[0], seen)
            radiance = radiance + _sent_back(tables, plan, at, light, of_it, point, between, needed)
        else:

            def add(radiance, one):
                return radiance + _sent_back(tables, plan, at, *one, point, between, needed), None

            radiance = jax.lax.scan(add, radiance, (lights, seen))[0]
    return radiance


def _sent_back(
    tables: Tables,
    plan: Plan,
    at: Arrival,
    light: AbstractLight,
    seen: Seen | None,
    point: SurfacePoint,
    between: Interpolation | None,
    needed,
) -> Vec3:
    """What the points send back of one light."""
    effects, models = plan.effects, plan.highlight_models
    model = point.models["highlight"] if effects.highlight and len(models) > 1 else None
    to_light, _, colour = stage(needed, light.arriving, point.position)
    ask = partial(light_terms, models if effects.highlight else None, effects.diffuse, model, light)
    terms = ask(point, to_light, needed)
    if between is not None:
        terms, colour = between.interpolated(ask, light, terms, colour, point, to_light, needed)
    for row in effect_rows():
        if row.at_lights is not None and row.name in effects:
            point = replace(point, coefficients=point.coefficients | row.at_lights(point, to_light))
    arrives = arriving_part(tables, plan, light, seen, at, point, to_light, needed)
    black = jnp.zeros_like(point.position.x)
    sent_back = Vec3(black, black, black)
    if effects.diffuse:
        sent_back = sent_back + point.coefficients["k_d"] * terms.diffuse
    if effects.highlight:
        sent_back = sent_back + point.coefficients["k_h"] * (terms.lit * terms.lobe)
    if effects.light_borders:
        arrives = arrives * within_borders(light, point)
    return sent_back * colour * arrives
