"""What one light does at a point, and the means of that where rays have a footprint."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..geometry import Footprint, Ray
from ..numerics._coverage import Linear, coverage, ramp
from ..numerics._safe import safe_divide
from ..numerics._stage import packed, stage
from ..numerics._vector import Vec3, dot
from ..scene import HIGHLIGHTS, AbstractLight
from ._models import apart
from ._phong import diffuse, lit, lobe, lobe_mean
from ._surface_point import SurfacePoint

FAINTEST = 1e-4
"""A highlight below this part of its top is not averaged over a footprint."""


class Terms(eqx.Module):
    """N.L, whether the light is before the surface, and the highlight's lobe; None for what is not called for.

    Numbers, or colours where the light itself was interpolated and its colour is in them.
    """

    diffuse: Float[Array, "n"] | Vec3 | None
    lit: Float[Array, "n"] | None
    lobe: Float[Array, "n"] | Vec3 | None


def light_terms(
    models: Sequence[str] | None,
    diffusing: bool,
    model: Int[Array, "n"] | None,
    light: AbstractLight,
    point: SurfacePoint,
    to_light: Vec3,
    needed,
) -> Terms:
    """The terms of a light. `models`: those of the highlights in the scene, None without highlights; `model`: of each
    point.
    """

    def at_points(point: SurfacePoint, model, to_light: Vec3) -> Terms:
        normal = point.shading_normal
        return Terms(
            diffuse(normal, to_light) if diffusing else None,
            None if models is None else lit(normal, to_light),
            None if models is None else _lobe(models, model, point, to_light),
        )

    terms = stage(needed, at_points, point, model, to_light)
    if point.footprint is None:
        return terms
    terms = _at_terminator(light, terms, point, to_light, needed)
    return terms if models is None else _over_footprint(models, model, light, terms, point, to_light)


def light_footprint(light: AbstractLight, position: Vec3, footprint: Footprint) -> Footprint:
    """How the ray from a surface to a light changes over the footprint there."""

    def turned(step: Vec3) -> Ray:
        return Ray(step, jax.jvp(lambda p: light.arriving(p)[0], (position,), (step,))[1])

    return Footprint(turned(footprint.across.origin), turned(footprint.down.origin))


def _lobe(models: Sequence[str], model, point: SurfacePoint, to_light: Vec3):
    away = apart(models, model, point.shading_normal, to_light, point.incoming)
    value = lobe(away, point.coefficients["phong_exponent"])
    return value if "off" not in models else jnp.where(model == HIGHLIGHTS.index("off"), 0, value)


def _at_terminator(light: AbstractLight, terms: Terms, point: SurfacePoint, to_light: Vec3, needed) -> Terms:
    """The mean of N.L and of its sign over the footprint, where it runs across the line between light and shade."""

    def near(point: SurfacePoint, to_light: Vec3):
        step, cosine = point.footprint.reach()[0], abs(dot(point.shading_normal, to_light))
        turned = step * (abs(point.curvature) + _turning(light, point.position) * cosine)
        return (cosine <= turned) & point.there

    def mean(position: Vec3, normal: Vec3, to_light: Vec3, footprint: Footprint, curvature):
        across, down = (
            dot(step.origin, to_light) * curvature + dot(normal, turned.direction)
            for step, turned in zip(footprint.sides(), light_footprint(light, position, footprint).sides(), strict=True)
        )
        height = Linear(dot(normal, to_light), across, down).within(1.0)
        return ramp(height), coverage(height)

    normal = point.shading_normal
    whole = diffuse(normal, to_light), lit(normal, to_light)
    doubtful = stage(needed, near, point, to_light)
    facing, before = packed(doubtful, mean, whole, point.position, normal, to_light, point.footprint, point.curvature)
    return Terms(None if terms.diffuse is None else facing, None if terms.lit is None else before, terms.lobe)


def _turning(light: AbstractLight, position: Vec3):
    """How fast the direction to the light turns with the place, at most: 1 / distance."""
    return safe_divide(1, light.arriving(position)[1])


def _over_footprint(
    models: Sequence[str], model, light: AbstractLight, terms: Terms, point: SurfacePoint, to_light: Vec3
) -> Terms:
    """The mean of the highlight's lobe over the footprint, where it shows."""

    def mean(model, position, normal, direction, to_light, footprint, curvature, exponent):
        def changed(step, turned):
            change = step.origin * curvature, turned.direction, step.direction
            return jax.jvp(lambda *a: apart(models, model, *a), (normal, to_light, direction), change)[1]

        sides = zip(footprint.sides(), light_footprint(light, position, footprint).sides(), strict=True)
        across, down = (changed(step, turned) for step, turned in sides)
        return lobe_mean(apart(models, model, normal, to_light, direction), across, down, exponent)

    shows = (terms.lobe > FAINTEST) & point.there
    blurred = packed(
        shows,
        mean,
        terms.lobe,
        model,
        point.position,
        point.shading_normal,
        point.incoming,
        to_light,
        point.footprint,
        point.curvature,
        point.coefficients["phong_exponent"],
    )
    return Terms(terms.diffuse, terms.lit, blurred)
