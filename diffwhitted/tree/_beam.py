"""Rays with a footprint: from a ray to what it meets, and from a parent to its child (Igehy 1999, ray differentials).

Two edges may cut the pixel of a ray. Past the silhouette of its surface, a third child goes on as if the object
were not there, with the share of the pixel that it leaves free. At the rim of total internal reflection the
transmitted child has the share of the pixel where cos_r**2 > 0, and the mean of cos_r**2 there in place of its
value in the middle: d cos_r then stays finite, where plain refraction has an infinite slope. Both are rare, and
are computed for the rays concerned alone.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..geometry import (
    LEAST_COVERAGE,
    NOTHING,
    Departure,
    Edge,
    Footprint,
    Hit,
    Ray,
    Shapes,
    covered,
    crosswise,
    curvature_at,
    edge_of,
    on_its_side,
    on_surface,
    part_of,
    silhouette_of,
    surface_at,
    uncovered,
    uv_at,
)  # fmt: skip
from ..illumination import SurfacePoint
from ..numerics._coverage import Linear, is_cut, ramp
from ..numerics._safe import normalise, safe_divide
from ..numerics._stage import always, packed, stage
from ..numerics._vector import Vec3, dot, where
from ..optics import Turn, refraction_radicand, sine_squared, turn_at
from ._arrival import MIRROR, PAST, TOTAL, TRANSMITTED, Arrival, Beam
from ._plan import Plan
from ._weights import weight_at_rim

WIDEST = 1.0
"""Radians."""


def arriving(
    shapes: Shapes,
    ray: Ray,
    footprint: Footprint,
    primitive: Int[Array, "n"],
    crossing: Int[Array, "n"],
    entering: Bool[Array, "n"],
    cut: Bool[Array, "n"],
    outline: Int[Array, "n"] | None,
    departure: Departure | None,
    needed: Bool[Array, ""],
) -> tuple[Hit, Vec3, Beam]:
    """Where the part of a pixel that its surface covers meets it: the hit, the direction, and what the footprint is
    there.
    """

    def meet(ray, footprint, primitive, crossing, entering):
        hit = surface_at(shapes, ray, primitive, crossing, entering)
        there = on_surface(ray, footprint, hit, curvature_at(shapes, hit))
        smooth = None if hit.lifted is None else (hit.shading_normal, hit.lifted)
        uv = None if hit.uv is None else (hit.uv, _uv_steps(shapes, hit, there))
        return hit.point, hit.normal, hit.distance, there, smooth, uv

    def meet_part(ray, footprint, primitive, crossing, entering, outline):
        here, outline = always(primitive), primitive if outline is None else outline
        # Find how the silhouette cuts the pixel, and go on with the part that the surface covers.
        silhouette = stage(here, lambda *a: silhouette_of(shapes, *a), ray, footprint, outline)
        edge = stage(here, edge_of, silhouette, primitive >= 0)
        ray, footprint = stage(here, covered, ray, footprint, edge)
        point, normal, *others = stage(here, meet, ray, footprint, primitive, crossing, entering)
        return point, normalise(normal), *others, ray.direction, edge

    # Meet the surface with whole pixels, and with parts of those that a silhouette cuts.
    surface = ray, footprint, primitive, crossing, entering
    zero, one = jnp.zeros_like(ray.origin.x), jnp.ones_like(ray.origin.x)
    whole = *stage(needed, meet, *surface), ray.direction, Edge(one, zero, zero, zero)
    met = packed(cut, meet_part, whole, *surface, outline)
    point, normal, distance, footprint, smooth, uv, direction, edge = met
    shading, lifted = (normal, None) if smooth is None else smooth
    uv, steps = (None, None) if uv is None else uv
    object = shapes.object_at(primitive)
    hit = Hit(primitive, object, crossing, entering, point, normal, shading, distance, lifted, uv=uv)
    return hit, direction, Beam(footprint, curvature_at(shapes, hit), edge, outline, departure, steps)


def _uv_steps(shapes: Shapes, hit: Hit, footprint: Footprint) -> tuple:
    """How the texture coordinates of a hit change along both sides of the pixel."""
    moved = (uv_at(shapes, hit.primitive, hit.point + side.origin) for side in footprint.sides())
    return tuple(tuple(there - here for there, here in zip(uv, hit.uv or (), strict=True)) for uv in moved)


def radicand(at: Arrival, eta: Float[Array, "n"]) -> Linear:
    """cos_r**2 over the pixel: d cos_r**2 = 2 eta**2 cos_i d cos_i.

    Where a ray was refracted into the object that it is about to leave, it meets the surface at the angle at which it
    came in, on a sphere: cos_r**2 is that of then, and never negative.
    """
    cosine = _cosine(at)
    by = 2 * eta * eta * cosine.value
    value = refraction_radicand(cosine.value, eta, sine_squared(at.direction, at.shading_normal, eta))
    square = Linear(value, cosine.across * by, cosine.down * by).within(1.0)
    returns, level = ~at.entering & (at.beam.footprint.within == at.primitive), jnp.zeros_like(by)
    return where(returns, Linear(jnp.maximum(square.value, 0), level, level), square)


def is_rim(square: Linear) -> Bool[Array, "n"]:
    """Does total internal reflection begin within the pixel?"""
    return is_cut(square, LEAST_COVERAGE)


def child_beam(
    plan: Plan, at: Arrival, point: SurfacePoint, branch: Int[Array, "n"], factor: Vec3, eta: Float[Array, "n"] | None
) -> tuple[Ray, Footprint, Vec3]:
    """The ray that leaves a parent along a branch, its footprint, and the share of its light that the parent passes
    on.
    """
    needed = always(branch)
    turn, special = stage(needed, lambda *a: _turn(plan, *a), at, branch, eta)
    ray, footprint = stage(needed, _turned, at, turn, branch)
    factor = factor * at.beam.edge.coverage
    whole = ray, footprint, factor
    ray, footprint, factor = packed(special, lambda *a: _special(plan, *a), whole, at, point, branch, factor, eta)
    return *stage(needed, _kept_small, ray, footprint), factor


def _kept_small(ray: Ray, footprint: Footprint) -> tuple[Ray, Footprint]:
    """A pixel whose directions lie further apart than `WIDEST` is lost: what it sees has nothing to do with a linear
    map.

    Its footprint is made smaller, and the ray has no derivative from there on, so that all stays finite.
    """
    apart_squared = jnp.maximum(*(dot(side.direction, side.direction) for side in footprint.sides()))
    lost = ~(apart_squared < WIDEST * WIDEST)
    scale = WIDEST / jnp.sqrt(jnp.where(lost & jnp.isfinite(apart_squared), apart_squared, WIDEST * WIDEST))
    smaller = Footprint(
        *(Ray(side.origin * scale, side.direction * scale) for side in footprint.sides()), footprint.within
    )
    return where(lost, jax.lax.stop_gradient((ray, smaller)), (ray, footprint))


def _turn(plan: Plan, at: Arrival, branch, eta) -> tuple[Turn, Bool[Array, "n"]]:
    """How the direction turns, and whether the ray is one of the rare ones."""
    special = branch == PAST
    if not plan.effects.refraction:
        return turn_at(_cosine(at)), special
    square = radicand(at, eta)
    if plan.effects.total_internal_reflection:
        special = special | is_rim(square)
    return turn_at(_cosine(at), eta, square.value, branch == TRANSMITTED), special


def _turned(at: Arrival, turn: Turn, branch) -> tuple[Ray, Footprint]:
    sides = [
        Ray(side.origin, turn.change(side.direction, side.origin * at.beam.curvature, at.shading_normal, change))
        for side, change in zip(at.beam.footprint.sides(), (turn.across, turn.down), strict=True)
    ]
    inside = jnp.where(
        branch == TRANSMITTED,
        at.entering,
        ~at.entering & (branch == MIRROR) & (at.beam.footprint.within == at.primitive),
    )
    direction = turn.direction(at.direction, at.shading_normal)
    if at.lifted is not None:
        direction = on_its_side(direction, at.normal, branch == TRANSMITTED)
    return Ray(at.point, direction), Footprint(*sides, jnp.where(inside, at.primitive, NOTHING))


def _special(plan: Plan, at: Arrival, point: SurfacePoint, branch, factor: Vec3, eta) -> tuple[Ray, Footprint, Vec3]:
    """A child that runs past its parent's surface, or that leaves it where total reflection begins."""
    here, beside = always(branch), branch == PAST
    past, rest = stage(here, _uncovered, at)
    left = safe_divide(1 - at.beam.edge.coverage, at.beam.edge.coverage)
    if not (plan.effects.refraction and plan.effects.total_internal_reflection):
        return past, rest, factor * left
    ray, footprint, before, mean = stage(here, _at_rim, at, branch, eta)
    at_rim = weight_at_rim(plan, point, branch, before, mean) * at.beam.edge.coverage
    return where(beside, (past, rest, factor * left), (ray, footprint, at_rim))


def _uncovered(at: Arrival) -> tuple[Ray, Footprint]:
    """From the depth of the surface on; where there are meshes, from where the ray set out: what is beside an outline
    or a crease may be nearer than what it covers.
    """
    point, footprint = at.point, crosswise(at.beam.footprint, at.direction)
    if at.beam.outline is not None:
        point = point - at.direction * at.distance
        sides = [Ray(s.origin - s.direction * at.distance, s.direction) for s in footprint.sides()]
        footprint = Footprint(*sides, footprint.within)
    return uncovered(Ray(point, at.direction), footprint, at.beam.edge)


def _at_rim(at: Arrival, branch, eta) -> tuple[Ray, Footprint, Float[Array, "n"], Float[Array, "n"]]:
    """A child that leaves from where total reflection begins in the pixel, the share of the pixel before that, and the
    mean of cos_r**2 there.

    It leaves from the middle of its own part and has the footprint of that part: a ray that stays within a sphere meets
    it at the same angle again and again, and would else lose light each time. The k_s of the light before the rim
    goes along with what is totally reflected.
    """
    square = radicand(at, eta)
    edge = edge_of(square, is_rim(square))
    mean = jnp.where(edge.coverage < 1, ramp(square) / edge.coverage, square.value)
    through, total, past = branch == TRANSMITTED, branch == TOTAL, jnp.where(edge.coverage < 1, 1 - edge.coverage, 1)
    kept = jnp.where(through, edge.coverage, jnp.where(total, past, 1))
    shift = edge.shift * jnp.where(through, 1, jnp.where(total, -edge.coverage / past, 0))
    moved, footprint = part_of(Ray(at.point, at.direction), at.beam.footprint, edge, kept, shift)
    normal = normalise(at.shading_normal + (moved.origin - at.point) * at.beam.curvature)
    beam = Beam(footprint, at.beam.curvature, edge, at.beam.outline, None)
    flat = normal if at.lifted is None else at.normal
    part = replace(
        at, point=moved.origin, normal=flat, shading_normal=normal, direction=moved.direction, outside=None,
        inside=None, beam=beam,
    )  # fmt: skip
    ray, footprint = _turned(part, turn_at(_cosine(part), eta, mean, through), branch)
    return Ray(ray.origin, normalise(ray.direction)), footprint, edge.coverage, mean


def _cosine(at: Arrival) -> Linear:
    """cos_i over the pixel."""
    return Linear(
        -dot(at.direction, at.shading_normal),
        *(
            -(dot(side.direction, at.shading_normal) + dot(at.direction, side.origin) * at.beam.curvature)
            for side in at.beam.footprint.sides()
        ),
    )
