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


def counted_from(first: int, number: Int[Array, "*n"]) -> Int[Array, "*n"]:
    """Numbers of surfaces where `first` has the number 0: those before it get numbers below `NOTHING`, which stays."""
    if first == 0:
        return number
    return jnp.where(number == NOTHING, NOTHING, number - first - (number < first))


class Departure(eqx.Module):
    """The surface that a ray starts on, in place of a small offset.

    A ray that leaves a convex surface outwards never meets it again; one that leaves it inwards
    meets it only at the far crossing. Knowing the surface and the side is therefore exact at any
    scale of the scene, where an offset along the normal must be tuned to it.
    """

    primitive: Int[Array, "*n"]
    """Number of the surface, or -1 for a ray that starts in free space."""
    inwards: Bool[Array, "*n"]
    """The ray travels on the inner side of that surface."""
    passed: tuple[Int[Array, "*n"], ...] = ()
    """Surfaces whose silhouette the ray runs past, -1 for none: it does not meet them."""

    def leaves_out(self, index) -> Bool[Array, "*n"]:
        """Is the surface one that the ray runs past?"""
        out = jnp.zeros(self.inwards.shape, bool)
        for one in self.passed:
            out = out | (one == index)
        return out

    def counted_from(self, first: int) -> "Departure":
        """The same where surface `first` has the number 0."""
        passed = tuple(counted_from(first, one) for one in self.passed)
        return Departure(counted_from(first, self.primitive), self.inwards, passed)
