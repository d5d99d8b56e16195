"""The light that a node adds itself: what its surface sends back of ambient light and lamps.

I = k_a I_a + sum over lights of s_j I_j (k_d (N.L_j) + k_h (highlight)), Parker et al. (1). The highlight
has no factor N.L. Only the terms that the plan's effects name are computed.
"""

import jax.numpy as jnp

from .._coverage import Linear, coverage, ramp
from .._vector import Vec3, dot, lookup, where
from ..geometry import Hit, Ray, outline_of
from ..illumination import diffuse, halfway_highlight, lit, reflected_highlight, tint
from ..scene import Tables
from ._beam import Meeting, light_beam
from ._plan import Plan
from ._record import Nodes, glass_by_material, most_crossed
from ._stage import stage


def local_radiance(tables: Tables, plan: Plan, nodes: Nodes, hit: Hit, incoming: Vec3, needed, met: Meeting | None = None) -> Vec3:
    """Linear RGB that leaves the surface towards where the ray came from; of no meaning for a miss.

    `needed`: whether any ray of the block is alive (see `stage`). With `met` it is the mean over the footprint.
    """
    effects, materials = plan.effects, tables.materials
    material = lookup(tables.material_of, hit.object)
    black = jnp.zeros_like(hit.point.x)
    radiance = Vec3(black, black, black)
    patterns = [_pattern(t, hit, met, needed) for t in tables.textures] if effects.textures else []
    if effects.ambient:
        k_a = _patterned(lookup(materials.k_a, material), material, patterns, plan.k_a_textures)
        radiance = radiance + k_a * tables.ambient
    if not effects.lighting:
        return radiance
    k_d = _patterned(lookup(materials.k_d, material), material, patterns, plan.k_d_textures) if effects.diffuse else None
    k_h = lookup(materials.k_h, material) if effects.highlight else None
    for number, light in enumerate(tables.lights):
        to_light, _, colour = stage(needed, light.arriving, hit.point)
        terms = stage(needed, lambda *a: _terms(tables, plan, light, *a), material, hit, to_light, incoming, met)  # noqa: B023
        sent_back = Vec3(black, black, black)
        if effects.diffuse:
            sent_back = sent_back + k_d * terms["diffuse"]
        if effects.highlight:
            sent_back = sent_back + k_h * terms["highlight"]
        seen = _arriving_share(tables, plan, nodes, number)
        if met is not None and effects.shadows:
            for part in nodes.shading[number]:
                share = stage(needed, lambda *a: _shown(tables, light, *a), hit, to_light, met, part)  # noqa: B023
                seen = seen * _past(tables, plan, part, share)
        radiance = radiance + sent_back * colour * seen
    return radiance


def _pattern(texture, hit: Hit, met: Meeting | None, needed) -> Vec3:
    """The colour of a texture at the hit, or its mean over the footprint."""
    return texture.at(hit.point) if met is None else stage(needed, texture.mean, hit.point, met.steps, met.slant)


def _terms(tables: Tables, plan: Plan, light, material, hit: Hit, to_light: Vec3, incoming: Vec3, met: Meeting | None) -> dict:
    """N.L and the highlight's lobe, whichever the plan calls for."""
    if met is None:
        facing, before = diffuse(hit.normal, to_light), lit(hit.normal, to_light)
    else:
        beam = light_beam(light, hit.point, met.steps)
        slopes = [dot(turn, to_light) + dot(hit.normal, side.direction)
                  for turn, side in zip(met.turns, (beam.across, beam.down), strict=True)]
        height = Linear(dot(hit.normal, to_light), *slopes).within(1.0)
        facing, before = ramp(height), coverage(height)
    terms = {}
    if plan.effects.diffuse:
        terms["diffuse"] = facing
    if plan.effects.highlight:
        terms["highlight"] = before * _highlight(tables, plan, material, hit, to_light, incoming)
    return terms


def _shown(tables: Tables, light, hit: Hit, to_light: Vec3, met: Meeting, part):
    """The share of the footprint from which a light is seen past an object that hides it in part."""
    outline = outline_of(tables.shapes, Ray(hit.point, to_light), light_beam(light, hit.point, met.steps), part)
    return coverage(-outline)


def _past(tables: Tables, plan: Plan, part, share):
    """What comes past the object: all that its outline leaves free, and what tinted glass lets through of the rest."""
    share = jnp.where(part >= 0, share, 1)
    if not plan.effects.tinted_shadows:
        return share
    material = lookup(tables.material_of, part)
    k_t = lookup(tables.materials.k_t, material)
    solid = lookup(jnp.asarray([thing in plan.solids for thing in range(len(plan.material_of))]), part)
    glass = lookup(jnp.asarray(plan.transparent), part)
    through = where(glass, where(solid, k_t * k_t, k_t), k_t * 0)
    return through * (1 - share) + Vec3(*(share,) * 3)


def _patterned(coefficient: Vec3, material, patterns, textures: tuple[int, ...]) -> Vec3:
    """The coefficient times the pattern of its texture, where the material has one."""
    for number, pattern in enumerate(patterns):
        if number in textures:
            wears_it = lookup(jnp.asarray([t == number for t in textures]), material)
            coefficient = where(wears_it, coefficient * pattern, coefficient)
    return coefficient


def _highlight(tables: Tables, plan: Plan, material, hit: Hit, to_light: Vec3, incoming: Vec3):
    exponent = lookup(tables.materials.phong_exponent, material)
    value = jnp.zeros_like(hit.point.x)
    for model, lobe in (("halfway", halfway_highlight), ("reflected", reflected_highlight)):
        if model in plan.highlight_models:
            here = lookup(jnp.asarray([m == model for m in plan.highlight_models]), material)
            value = jnp.where(here, lobe(hit.normal, to_light, incoming, exponent), value)
    return value


def _arriving_share(tables: Tables, plan: Plan, nodes: Nodes, light: int):
    """s_j: 0 or 1, times k_t for each transparent surface on the way where shadows are tinted."""
    if not plan.effects.shadows:
        return 1
    visible = nodes.visible[light].astype(tables.ambient.dtype)
    if not plan.effects.tinted_shadows:
        return visible
    share = Vec3(visible, visible, visible)
    for (material, made_of_it), crossed in zip(glass_by_material(plan).items(), nodes.crossed[light], strict=True):
        k_t = tables.materials.k_t
        k_t_of_it = Vec3(k_t.x[material], k_t.y[material], k_t.z[material])
        share = share * tint(k_t_of_it, crossed.astype(jnp.int32), most_crossed(made_of_it))
    return share
