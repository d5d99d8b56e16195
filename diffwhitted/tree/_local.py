"""The light that a node adds itself: what its surface sends back of ambient light and lamps.

I = k_a I_a + sum over lights of s_j I_j (k_d (N.L_j) + k_h (highlight)), Parker et al. (1). The highlight
has no factor N.L. Only the terms that the plan's effects name are computed.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry import Ray, outline_of
from ..illumination import diffuse, halfway_apart, lit, lobe, lobe_mean, reflected_apart, tint
from ..numerics._coverage import Linear, coverage, ramp
from ..numerics._safe import safe_divide
from ..numerics._stage import packed, stage
from ..numerics._vector import Vec3, dot, lookup, where
from ..scene import Tables
from ._arrival import Arrival
from ._beam import light_beam, slant
from ._plan import Plan
from ._record import Nodes, glass_by_material, most_crossed

FAINTEST = 1e-4
"""A highlight below this share of its top is not averaged over a footprint."""


def local_radiance(tables: Tables, plan: Plan, nodes: Nodes, at: Arrival, needed) -> Vec3:
    """Linear RGB that leaves the surface towards where the ray came from; of no meaning for a miss.

    `needed`: whether any ray of the block is alive (see `stage`). Where rays have a footprint it is the mean over it.
    """
    effects, materials = plan.effects, tables.materials
    material = lookup(tables.material_of, at.object)
    black = jnp.zeros_like(at.point.x)
    radiance = Vec3(black, black, black)
    patterns = [_pattern(t, at, needed) for t in tables.textures] if effects.textures else []
    if effects.ambient:
        k_a = _patterned(lookup(materials.k_a, material), material, patterns, plan.k_a_textures)
        radiance = radiance + k_a * tables.ambient
    if not effects.lighting:
        return radiance
    k_d = (
        _patterned(lookup(materials.k_d, material), material, patterns, plan.k_d_textures) if effects.diffuse else None
    )
    k_h = lookup(materials.k_h, material) if effects.highlight else None
    for number, light in enumerate(tables.lights):
        to_light, _, colour = stage(needed, light.arriving, at.point)
        terms = stage(needed, lambda *a: _terms(tables, plan, *a), material, at, to_light)
        share = _arriving_share(tables, plan, nodes, number)
        if at.beam is not None:
            terms = _at_terminator(light, terms, at, to_light, needed)
            terms = _over_footprint(tables, plan, light, terms, material, at, to_light)
            share = share * _past_edges(tables, plan, light, nodes, number, at, to_light)
        sent_back = Vec3(black, black, black)
        if effects.diffuse:
            sent_back = sent_back + k_d * terms.diffuse
        if effects.highlight:
            sent_back = sent_back + k_h * (terms.lit * terms.lobe)
        radiance = radiance + sent_back * colour * share
    return radiance


class Terms(eqx.Module):
    """What a light does at a point: N.L, whether it is before the surface, and the highlight's lobe; None if not called for."""

    diffuse: Float[Array, "n"] | None
    lit: Float[Array, "n"] | None
    lobe: Float[Array, "n"] | None


def _terms(tables: Tables, plan: Plan, material, at: Arrival, to_light: Vec3) -> Terms:
    effects = plan.effects
    return Terms(
        diffuse(at.normal, to_light) if effects.diffuse else None,
        lit(at.normal, to_light) if effects.highlight else None,
        _highlight(tables, plan, material, at, to_light) if effects.highlight else None,
    )


def _at_terminator(light, terms: Terms, at: Arrival, to_light: Vec3, needed) -> Terms:
    """The mean of N.L and of its sign over the footprint, where it runs across the line between light and shade."""

    def near(at, to_light):
        step, cosine = at.beam.footprint.reach()[0], abs(dot(at.normal, to_light))
        turned = step * (abs(at.beam.curvature) + _turning(light, at.point) * cosine)
        return (cosine <= turned) & (at.object >= 0)

    def mean(point, normal, to_light, beam):
        across, down = (
            dot(step.origin, to_light) * beam.curvature + dot(normal, turned.direction)
            for step, turned in zip(
                beam.footprint.sides(), light_beam(light, point, beam.footprint).sides(), strict=True
            )
        )
        height = Linear(dot(normal, to_light), across, down).within(1.0)
        return ramp(height), coverage(height)

    whole = diffuse(at.normal, to_light), lit(at.normal, to_light)
    doubtful = stage(needed, near, at, to_light)
    facing, before = packed(doubtful, mean, whole, at.point, at.normal, to_light, at.beam)
    return Terms(None if terms.diffuse is None else facing, None if terms.lit is None else before, terms.lobe)


def _turning(light, point: Vec3):
    """How fast the direction to the light turns with the place, at most: 1 / distance."""
    return safe_divide(1, light.arriving(point)[1])


def _pattern(texture, at: Arrival, needed) -> Vec3:
    """The colour of a texture at the hit, or its mean over the footprint."""
    if at.beam is None:
        return texture.at(at.point)
    steps = tuple(side.origin for side in at.beam.footprint.sides())
    slants = stage(needed, slant, at)
    some, much = stage(needed, texture.varies, at.point, steps, slants)
    colour = packed(some & (at.object >= 0), texture.mean, texture.at(at.point), at.point, steps)
    return packed(much & (at.object >= 0), texture.mean_in_perspective, colour, at.point, steps, slants)


def _past_edges(tables: Tables, plan: Plan, light, nodes: Nodes, number: int, at: Arrival, to_light: Vec3):
    """What comes past the objects that hide the light from part of the footprint."""
    one = jnp.ones_like(at.point.x)
    through = whole = Vec3(one, one, one) if plan.effects.tinted_shadows else one
    if not plan.effects.shadows:
        return through

    def look(point, to_light, footprint, part):
        outline = outline_of(tables.shapes, Ray(point, to_light), light_beam(light, point, footprint), part)
        return _past(tables, plan, part, coverage(-outline))

    for part in nodes.shading[number]:
        through = through * packed(part >= 0, look, whole, at.point, to_light, at.beam.footprint, part)
    return through


def _past(tables: Tables, plan: Plan, part, share):
    """What comes past the object: all that its outline leaves free, and what tinted glass lets through of the rest."""
    if not plan.effects.tinted_shadows:
        return share
    material = lookup(tables.material_of, part)
    k_t = lookup(tables.materials.k_t, material)
    solid = lookup(jnp.asarray([thing in plan.solids for thing in range(len(plan.material_of))]), part)
    glass = lookup(jnp.asarray(plan.transparent), part)
    through = where(glass, where(solid, k_t * k_t, k_t), jax.tree.map(jnp.zeros_like, k_t))
    return through * (1 - share) + Vec3(*(share,) * 3)


def _patterned(coefficient: Vec3, material, patterns, textures: tuple[int, ...]) -> Vec3:
    """The coefficient times the pattern of its texture, where the material has one."""
    for number, pattern in enumerate(patterns):
        if number in textures:
            wears_it = lookup(jnp.asarray([t == number for t in textures]), material)
            coefficient = where(wears_it, coefficient * pattern, coefficient)
    return coefficient


def _highlight(tables: Tables, plan: Plan, material, at: Arrival, to_light: Vec3):
    value = lobe(
        _apart(plan, material, at.normal, to_light, at.direction), lookup(tables.materials.phong_exponent, material)
    )
    if "off" not in plan.highlight_models:
        return value
    return jnp.where(lookup(jnp.asarray([model == "off" for model in plan.highlight_models]), material), 0, value)


def _apart(plan: Plan, material, normal: Vec3, to_light: Vec3, incoming: Vec3) -> Vec3:
    """The difference whose length decides the highlight, by the material's model."""
    models = [("halfway", halfway_apart), ("reflected", reflected_apart)]
    found = [(model, apart(normal, to_light, incoming)) for model, apart in models if model in plan.highlight_models]
    value = found[0][1] if found else jax.tree.map(jnp.zeros_like, normal)
    for model, other in found[1:]:
        value = where(lookup(jnp.asarray([m == model for m in plan.highlight_models]), material), other, value)
    return value


def _over_footprint(tables: Tables, plan: Plan, light, terms: Terms, material, at: Arrival, to_light: Vec3) -> Terms:
    """The mean of the highlight's lobe over the footprint, where it shows."""
    if terms.lobe is None:
        return terms

    def mean(material, point, normal, direction, to_light, beam):
        def changed(step, turned):
            change = step.origin * beam.curvature, turned.direction, step.direction
            return jax.jvp(lambda *a: _apart(plan, material, *a), (normal, to_light, direction), change)[1]

        sides = zip(beam.footprint.sides(), light_beam(light, point, beam.footprint).sides(), strict=True)
        across, down = (changed(step, turned) for step, turned in sides)
        return lobe_mean(
            _apart(plan, material, normal, to_light, direction),
            across,
            down,
            lookup(tables.materials.phong_exponent, material),
        )

    shows = (terms.lobe > FAINTEST) & (at.object >= 0)
    blurred = packed(shows, mean, terms.lobe, material, at.point, at.normal, at.direction, to_light, at.beam)
    return Terms(terms.diffuse, terms.lit, blurred)


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
