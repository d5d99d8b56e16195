"""What shapes share that are known by an equation F(x) = 0: roots along a ray, and their derivatives."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..geometry import Ray
from ..numerics._safe import safe_divide
from ..numerics._vector import Vec3, dot

Real = Float[Array, "*n"]


def closest(ray: Ray, middle: Vec3) -> tuple[Real, Vec3]:
    """The distance at which the ray's line is closest to a point, and the way from there to the ray's point there.

    Where everything else is counted from: what lies far away keeps its digits. The distance is a constant to
    derivatives, as it may be any.
    """
    offset = ray.origin - middle
    along = jax.lax.stop_gradient(-dot(offset, ray.direction))
    return along, offset + ray.direction * along


def settled(distance: Real, value: Real, slope: Real) -> Real:
    """A root t of F(o + t d) = 0 that was found without derivatives, with those of the implicit function.

    dt = -dF / (dF/dt), in whatever F depends on; the value is not touched. `value`: F at the root, a function of all;
    `slope`: dF/dt there. Edge: a ray that touches (slope 0) has derivative 0.
    """
    distance, slope = jax.lax.stop_gradient((distance, slope))
    return distance - safe_divide(1, slope) * (value - jax.lax.stop_gradient(value))


def quadratic(a: Real, h: Real, c: Real, touched: Bool[Array, "*n"]) -> tuple[Real, Real, Bool[Array, "*n"]]:
    """Where a s**2 + 2 h s + c falls through 0, where it rises through it, and whether it does either.

    Falls at (-h - root) / a, rises at (-h + root) / a, each in the form without a difference of like numbers; infinite
    where the line has one root only. `touched`: there are roots, whatever rounding says. No derivatives.
    """
    radicand = h * h - a * c
    root = jnp.sqrt(jnp.maximum(radicand, 0))
    up = h >= 0
    q = jnp.where(up, -(h + root), root - h)
    far = jnp.where(a == 0, jnp.where(up, -jnp.inf, jnp.inf), safe_divide(q, a))
    near = safe_divide(c, q)
    there = ((radicand > 0) | touched) & ((a != 0) | (h != 0))
    return jnp.where(up, far, near), jnp.where(up, near, far), there


def finite(number: Real) -> Real:
    """The number, or 0 in place of one that is not finite."""
    return jnp.where(jnp.isfinite(number), number, 0)


def ahead(
    enters: Real, leaves: Real, met: Bool[Array, "*n"], on_it: Bool[Array, "*n"], inwards: Bool[Array, "*n"]
) -> tuple[Real, Real]:
    """Of the two crossings of a convex body those that lie ahead; infinity in place of the others.

    A ray that starts on it meets nothing of it outwards, and inwards the way out, however near.
    """
    near = jnp.where(met & ~on_it & (enters > 0), enters, jnp.inf)
    out = jnp.where(on_it, inwards, met & (leaves > 0))
    return near, jnp.where(out & jnp.isfinite(leaves), jnp.where(on_it, jnp.maximum(leaves, 0), leaves), jnp.inf)
