"""The light that a node adds itself: what its surface sends back of ambient light and lamps.

I = k_a I_a + sum over lights of s_j I_j (k_d (N.L_j) + k_h (highlight)), Parker et al. (1). The highlight
has no factor N.L. Only the terms that the plan's effects name are computed.
"""

import jax.numpy as jnp

from .._vector import Vec3, lookup, where
from ..geometry import Hit
from ..illumination import diffuse, halfway_highlight, reflected_highlight, tint
from ..scene import Tables
from ._plan import Plan
from ._record import Nodes, glass_by_material, most_crossed
from ._stage import stage


def local_radiance(tables: Tables, plan: Plan, nodes: Nodes, hit: Hit, incoming: Vec3, needed) -> Vec3:
    """Linear RGB that leaves the surface towards where the ray came from; of no meaning for a miss.

    `needed`: whether any ray of the block is alive (see `stage`).
    """
    effects, materials = plan.effects, tables.materials
    material = lookup(tables.material_of, hit.object)
    black = jnp.zeros_like(hit.distance)
    radiance = Vec3(black, black, black)
    patterns = [t.at(hit.point) for t in tables.textures] if effects.textures else []
    if effects.ambient:
        k_a = _patterned(lookup(materials.k_a, material), material, patterns, plan.k_a_textures)
        radiance = radiance + k_a * tables.ambient
    if not effects.lighting:
        return radiance
    k_d = _patterned(lookup(materials.k_d, material), material, patterns, plan.k_d_textures) if effects.diffuse else None
    k_h = lookup(materials.k_h, material) if effects.highlight else None
    for number, light in enumerate(tables.lights):
        to_light, _, colour = stage(needed, light.arriving, hit.point)
        terms = stage(needed, lambda *a: _terms(tables, plan, *a), material, hit, to_light, incoming)
        sent_back = Vec3(black, black, black)
        if effects.diffuse:
            sent_back = sent_back + k_d * terms["diffuse"]
        if effects.highlight:
            sent_back = sent_back + k_h * terms["highlight"]
        radiance = radiance + sent_back * colour * _arriving_share(tables, plan, nodes, number)
    return radiance


def _terms(tables: Tables, plan: Plan, material, hit: Hit, to_light: Vec3, incoming: Vec3) -> dict:
    """N.L and the highlight's lobe, whichever the plan calls for."""
    terms = {}
    if plan.effects.diffuse:
        terms["diffuse"] = diffuse(hit.normal, to_light)
    if plan.effects.highlight:
        terms["highlight"] = _highlight(tables, plan, material, hit, to_light, incoming)
    return terms


def _patterned(coefficient: Vec3, material, patterns, textures: tuple[int, ...]) -> Vec3:
    """The coefficient times the pattern of its texture, where the material has one."""
    for number, pattern in enumerate(patterns):
        if number in textures:
            wears_it = lookup(jnp.asarray([t == number for t in textures]), material)
            coefficient = where(wears_it, coefficient * pattern, coefficient)
    return coefficient


def _highlight(tables: Tables, plan: Plan, material, hit: Hit, to_light: Vec3, incoming: Vec3):
    exponent = lookup(tables.materials.phong_exponent, material)
    value = jnp.zeros_like(hit.distance)
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
