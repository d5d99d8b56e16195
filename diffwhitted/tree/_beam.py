"""Children of a ray that has a footprint: Igehy's ray differentials (1999) through mirrors and glass.

Two edges may cut the pixel of a parent. Past the outline of its object, a third child goes on as if the object
were not there, with the share of the pixel that it leaves free. At the rim of total internal reflection the
transmitted child has the share of the pixel where cos_r**2 > 0, and the mean of cos_r**2 there in place of its
value in the middle: d cos_r then stays finite, where plain refraction has an infinite slope.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._coverage import Linear, is_cut, ramp
from .._safe import normalise, safe_divide
from .._vector import Vec3, dot, lookup, where
from ..geometry import Departure, Footprint, Ray, Shapes, covered, edge_of, narrowed, outline_of, spread, turning_at, uncovered
from ..optics import mirrored, refracted, refracted_change, refraction_radicand
from ..scene import Light, Tables
from ._arrival import PAST, TOTAL, TRANSMITTED, Arrival, Beam
from ._plan import Plan

STEEPEST = 1.6
"""Slant beyond which a footprint that runs to the horizon is cut off: at 2 its far end is infinitely far away."""
LEAST = 1e-3
"""A rim that leaves less than this share of a pixel on one side does not count."""


class Meeting(eqx.Module):
    """How the covered part of a pixel meets the surface: all to first order, along both sides of the pixel."""

    ray: Ray
    footprint: Footprint
    steps: tuple[Vec3, Vec3]
    """Of the point, along the surface."""
    turns: tuple[Vec3, Vec3]
    """Of the normal on the side of the ray."""
    slant: tuple[Float[Array, "n"], Float[Array, "n"]]
    """Perspective: on a flat surface the point is at (dP_u u + dP_v v) / (1 + slant_u u + slant_v v); else 0."""


def arriving_beam(shapes: Shapes, ray: Ray, footprint: Footprint, object: Int[Array, "n"], cut: Bool[Array, "n"],
                  departure: Departure | None = None) -> tuple[Beam, Ray]:
    """What a ray keeps of its way to an object whose outline may cut the pixel, and the ray through the covered part."""
    edge = edge_of(outline_of(shapes, ray, footprint, object), cut)
    return Beam(ray.origin, footprint, edge, departure), covered(ray, footprint, edge)[0]


def light_beam(light: Light, point: Vec3, steps: tuple[Vec3, Vec3]) -> Footprint:
    """How the ray from a surface to a light changes over the footprint there."""
    return Footprint(*(Ray(step, jax.jvp(lambda p: light.arriving(p)[0], (point,), (step,))[1]) for step in steps))


def meeting(shapes: Shapes, at: Arrival) -> Meeting:
    ray, footprint = covered(Ray(at.beam.origin, at.direction), at.beam.footprint, at.beam.edge)
    steps = spread(ray, footprint, at.hit())
    turns = turning_at(shapes, at.hit(), steps)
    flat = sum(dot(turn, turn) for turn in turns) == 0
    towards = dot(ray.direction, at.normal)
    slant = [jnp.clip(jnp.where(flat, safe_divide(dot(side.direction, at.normal), towards), 0), -STEEPEST, STEEPEST)
             for side in (footprint.across, footprint.down)]
    return Meeting(ray, footprint, steps, turns, tuple(slant))


def rim(shapes: Shapes, at: Arrival, eta: Float[Array, "n"]) -> tuple[Bool[Array, "n"], Bool[Array, "n"]]:
    """In which pixels some of the light, and in which all of it, is past the critical angle."""
    radicand = _radicand(meeting(shapes, at), at.normal, eta)
    cut = is_cut(radicand, LEAST)
    return (radicand.value < 0) | cut, (radicand.value < 0) & ~cut


def child_beam(tables: Tables, plan: Plan, at: Arrival, branch: Int[Array, "n"], factor: Vec3,
               eta: Float[Array, "n"] | None) -> tuple[Ray, Footprint, Vec3]:
    """The ray that leaves a parent along a branch, its footprint, and the share of its light that the parent passes on."""
    met = meeting(tables.shapes, at)
    direction, turns = _mirrored(met, at.normal)
    footprint = _on_surface(met, turns)
    if plan.effects.refraction:
        through = branch == TRANSMITTED
        bent, bent_footprint, open_share = _refracted(plan, met, at.normal, eta)
        direction, footprint = where(through, (bent, bent_footprint), (direction, footprint))
        factor = where(through, factor * open_share, factor)
        if plan.effects.total_internal_reflection and plan.total_reflection_is_full:
            reflected = _mirror_coefficient(tables, plan, at) * open_share
            factor = where(branch == TOTAL, factor * (1 - open_share) + reflected, factor)
    past, rest = uncovered(Ray(at.beam.origin, at.direction), at.beam.footprint, at.beam.edge)
    beside, kept = branch == PAST, at.beam.edge.share
    ray, footprint = where(beside, (past, rest), (Ray(at.point, direction), footprint))
    return ray, footprint, factor * jnp.where(beside, 1 - kept, kept)


def _mirrored(met: Meeting, normal: Vec3) -> tuple[Vec3, list[Vec3]]:
    """The mirror direction and its change along both sides of the pixel."""
    sides = (met.footprint.across, met.footprint.down)
    turns = [jax.jvp(mirrored, (met.ray.direction, normal), (side.direction, turn))[1]
             for side, turn in zip(sides, met.turns, strict=True)]
    return mirrored(met.ray.direction, normal), turns


def _refracted(plan: Plan, met: Meeting, normal: Vec3, eta) -> tuple[Vec3, Footprint, Float[Array, "n"]]:
    """The transmitted direction, its footprint, and the share of the pixel that is not past the critical angle."""
    radicand = _radicand(met, normal, eta)
    edge = edge_of(radicand, is_cut(radicand, LEAST) & plan.effects.total_internal_reflection)
    square = jnp.where(edge.share < 1, ramp(radicand) / edge.share, radicand.value)
    sides = (met.footprint.across, met.footprint.down)
    turns = [refracted_change(met.ray.direction, normal, eta, square, side.direction, turn)
             for side, turn in zip(sides, met.turns, strict=True)]
    direction = normalise(refracted(met.ray.direction, normal, eta, square))
    return direction, narrowed(_on_surface(met, turns), edge, edge.share), edge.share


def _on_surface(met: Meeting, turns) -> Footprint:
    return Footprint(*(Ray(step, turn) for step, turn in zip(met.steps, turns, strict=True)))


def _radicand(met: Meeting, normal: Vec3, eta) -> Linear:
    """cos_r**2 over the pixel: d cos_r**2 = 2 eta**2 cos_i d cos_i."""
    cos_i = -dot(met.ray.direction, normal)
    changes = [-(dot(side.direction, normal) + dot(met.ray.direction, turn)) * (2 * eta * eta * cos_i)
               for side, turn in zip((met.footprint.across, met.footprint.down), met.turns, strict=True)]
    return Linear(refraction_radicand(cos_i, eta), *changes).within(1.0)


def _mirror_coefficient(tables: Tables, plan: Plan, at: Arrival) -> Vec3:
    k_s = lookup(tables.materials.k_s, lookup(tables.material_of, at.object))
    return k_s if plan.effects.reflection else k_s * 0
