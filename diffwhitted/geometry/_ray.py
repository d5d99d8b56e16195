"""Rays, and the surface that a ray leaves."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._vector import Vec3

NOTHING = -1


class Ray(eqx.Module):
    """Half lines: a point and the unit direction of travel."""

    origin: Vec3
    direction: Vec3

    def at(self, distance: Float[Array, "*n"]) -> Vec3:
        return self.origin + self.direction * distance


class Departure(eqx.Module):
    """The surface that a ray starts on, in place of a small offset.

    A ray that leaves a convex primitive outwards never meets it again; one that leaves it inwards
    meets it only at the far crossing. Knowing the primitive and the side is therefore exact at any
    scale of the scene, where an offset along the normal must be tuned to it.
    """

    object: Int[Array, "*n"]
    """Index of the primitive, or -1 for a ray that starts in free space."""
    inwards: Bool[Array, "*n"]
    """The ray travels on the inner side of that primitive."""
    passed: tuple[Int[Array, "*n"], ...] = ()
    """Primitives whose outline the ray runs past, -1 for none: it does not meet them."""

    def leaves_out(self, index):
        """Is the primitive one that the ray runs past?"""
        out = jnp.zeros(self.inwards.shape, bool)
        for one in self.passed:
            out = out | (one == index)
        return out
