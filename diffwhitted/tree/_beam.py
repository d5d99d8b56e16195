"""Rays with a footprint: from a ray to what it meets, and from a parent to its child (Igehy 1999, ray differentials).

Two edges may cut the pixel of a ray. Past the outline of its object, a third child goes on as if the object
were not there, with the share of the pixel that it leaves free. At the rim of total internal reflection the
transmitted child has the share of the pixel where cos_r**2 > 0, and the mean of cos_r**2 there in place of its
value in the middle: d cos_r then stays finite, where plain refraction has an infinite slope. Both are rare, and
are computed for the rays concerned alone.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._coverage import Linear, is_cut, ramp
from .._safe import normalise, safe_divide
from .._vector import Vec3, dot, lookup, where
from ..geometry import Departure, Edge, Footprint, Hit, Ray, Shapes, covered, edge_of, narrowed, outline_of, spread, turning_at, uncovered
from ..optics import Turn, refraction_radicand, turn_at
from ..scene import Light, Tables
from ._arrival import PAST, TOTAL, TRANSMITTED, Arrival, Beam
from ._plan import Plan
from ._stage import packed, stage

STEEPEST = 1.6
"""Slant beyond which a footprint that runs to the horizon is cut off: at 2 its far end is infinitely far away."""
LEAST = 1e-3
"""A rim that leaves less than this share of a pixel on one side does not count."""


class Meeting(eqx.Module):
    """How a pixel meets the surface: all to first order, along both sides of the pixel."""

    steps: tuple[Vec3, Vec3]
    """Of the point, along the surface."""
    turns: tuple[Vec3, Vec3]
    """Of the normal on the side of the ray."""


def arriving(shapes: Shapes, ray: Ray, footprint: Footprint, object: Int[Array, "n"], cut: Bool[Array, "n"],
             departure: Departure | None = None) -> tuple[Ray, Beam]:
    """The ray through the part of its pixel that its object covers, and what it keeps of its way there."""

    def cut_one(ray, footprint, object):
        edge = edge_of(outline_of(shapes, ray, footprint, object), object >= 0)
        return *covered(ray, footprint, edge), edge

    zero = jnp.zeros_like(ray.origin.x)
    whole = Edge(zero + 1, zero, zero, zero)
    ray, footprint, edge = packed(cut, cut_one, (ray, footprint, whole), ray, footprint, object)
    return ray, Beam(ray.origin, footprint, edge, departure)


def meeting(shapes: Shapes, ray: Ray, footprint: Footprint, hit: Hit) -> Meeting:
    steps = spread(ray, footprint, hit)
    return Meeting(steps, turning_at(shapes, hit, steps))


def slant(met: Meeting, ray: Ray, footprint: Footprint, normal: Vec3) -> tuple[Float[Array, "n"], Float[Array, "n"]]:
    """Perspective: on a flat surface the point is at (dP_u u + dP_v v) / (1 + slant_u u + slant_v v); 0 on others."""
    flat, towards = sum(dot(turn, turn) for turn in met.turns) == 0, dot(ray.direction, normal)
    return tuple(jnp.clip(jnp.where(flat, safe_divide(dot(side.direction, normal), towards), 0), -STEEPEST, STEEPEST)
                 for side in (footprint.across, footprint.down))


def light_beam(light: Light, point: Vec3, steps: tuple[Vec3, Vec3]) -> Footprint:
    """How the ray from a surface to a light changes over the footprint there."""
    return Footprint(*(Ray(step, jax.jvp(lambda p: light.arriving(p)[0], (point,), (step,))[1]) for step in steps))


def radicand(at: Arrival, met: Meeting, eta: Float[Array, "n"]) -> Linear:
    """cos_r**2 over the pixel: d cos_r**2 = 2 eta**2 cos_i d cos_i."""
    cos_i, changes = _cosine(at, met)
    return Linear(refraction_radicand(cos_i, eta), *(change * (2 * eta * eta * cos_i) for change in changes)).within(1.0)


def is_rim(square: Linear) -> Bool[Array, "n"]:
    """Does total internal reflection begin within the pixel?"""
    return is_cut(square, LEAST)


def child_beam(tables: Tables, plan: Plan, at: Arrival, branch: Int[Array, "n"], factor: Vec3,
               eta: Float[Array, "n"] | None) -> tuple[Ray, Footprint, Vec3]:
    """The ray that leaves a parent along a branch, its footprint, and the share of its light that the parent passes on."""
    needed = branch[0] >= 0
    met = stage(needed, lambda at: meeting(tables.shapes, at.ray(), at.beam.footprint, at.hit()), at)
    turn, changes, special = stage(needed, lambda *a: _turn(plan, *a), at, met, branch, eta)
    ray, footprint = stage(needed, _turned, at, met, turn, changes)
    factor = factor * at.beam.edge.share
    return packed(special, lambda *a: _special(tables, plan, *a), (ray, footprint, factor), at, branch, factor, eta)


def _turn(plan: Plan, at: Arrival, met: Meeting, branch, eta):
    """How the direction turns, how cos_i changes, and whether the ray is one of the rare ones."""
    cos_i, changes = _cosine(at, met)
    special = branch == PAST
    if not plan.effects.refraction:
        return turn_at(cos_i), changes, special
    square = radicand(at, met, eta)
    if plan.effects.total_internal_reflection:
        special = special | is_rim(square)
    return turn_at(cos_i, eta, square.value, branch == TRANSMITTED), changes, special


def _turned(at: Arrival, met: Meeting, turn: Turn, changes) -> tuple[Ray, Footprint]:
    sides = zip((at.beam.footprint.across, at.beam.footprint.down), met.steps, met.turns, changes, strict=True)
    footprint = [Ray(step, turn.change(at.normal, side.direction, normal_turn, change)) for side, step, normal_turn, change in sides]
    return Ray(at.point, turn.direction(at.direction, at.normal)), Footprint(*footprint)


def _special(tables: Tables, plan: Plan, at: Arrival, branch, factor: Vec3, eta) -> tuple[Ray, Footprint, Vec3]:
    """A child that runs past its parent's object, or that leaves it where total reflection begins."""
    past, rest = uncovered(at.ray(), at.beam.footprint, at.beam.edge)
    beside = branch == PAST
    left = safe_divide(1 - at.beam.edge.share, at.beam.edge.share)
    if not (plan.effects.refraction and plan.effects.total_internal_reflection):
        return past, rest, factor * left
    met = meeting(tables.shapes, at.ray(), at.beam.footprint, at.hit())
    square = radicand(at, met, eta)
    edge = edge_of(square, is_rim(square))
    open_share = edge.share
    mean = jnp.where(open_share < 1, ramp(square) / open_share, square.value)
    cos_i, changes = _cosine(at, met)
    through = branch == TRANSMITTED
    ray, footprint = _turned(at, met, turn_at(cos_i, eta, mean, through), changes)
    ray = Ray(ray.origin, normalise(ray.direction))
    footprint = where(through, narrowed(footprint, edge, open_share), footprint)
    factor = where(through, factor * open_share, factor)
    if plan.total_reflection_is_full:
        k_s = lookup(tables.materials.k_s, lookup(tables.material_of, at.object)) * (open_share if plan.effects.reflection else 0)
        whole = factor * (1 - open_share) + factor * k_s
        factor = where(branch == TOTAL, whole, factor)
    return where(beside, (past, rest, factor * left), (ray, footprint, factor))


def _cosine(at: Arrival, met: Meeting):
    """cos_i, and its change along both sides of the pixel."""
    sides = zip((at.beam.footprint.across, at.beam.footprint.down), met.turns, strict=True)
    return -dot(at.direction, at.normal), [-(dot(side.direction, at.normal) + dot(at.direction, turn)) for side, turn in sides]
