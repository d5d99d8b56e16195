"""Rays, and the surface that a ray leaves."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerics._vector import Vec3, lookup

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


class Sheets(eqx.Module):
    """Surfaces that lie in one place, so that rounding must not decide in which order a ray meets them (see
    `_sheets`).
    """

    sheet: Int[Array, "surfaces"]
    """The number of the sheet that a surface is part of, -1 for one that lies alone."""
    facing: Bool[Array, "surfaces"]
    """Its outer side is the upper side of the sheet."""
    layer: Int[Array, "surfaces"]
    """Its place within the sheet, upwards."""


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
    sheet: Int[Array, "*n"] | None = None
    """That of the surface, where some surfaces lie in one place; known within a search only."""
    sheet_of: Int[Array, "surfaces"] | None = None
    """Of all surfaces."""

    def starts_on(self, index) -> Bool[Array, "*n"]:
        """Does the ray start on the surface, or on one in the same place?"""
        on_it = self.primitive == index
        if self.sheet is None or self.sheet_of is None:
            return on_it
        return on_it | ((self.sheet >= 0) & (self.sheet == self.sheet_of[index]))

    def leaves_out(self, index) -> Bool[Array, "*n"]:
        """Is the surface one that the ray runs past?"""
        out = jnp.zeros(self.inwards.shape, bool)
        for one in self.passed:
            out = out | (one == index)
        return out

    def counted_from(self, first: int, sheets: Sheets | None = None) -> "Departure":
        """The same where surface `first` has the number 0."""
        passed = tuple(counted_from(first, one) for one in self.passed)
        primitive = counted_from(first, self.primitive)
        if sheets is None:
            return Departure(primitive, self.inwards, passed)
        return Departure(primitive, self.inwards, passed, sheet_at(sheets, self.primitive), sheets.sheet[first:])


def sheet_at(sheets: Sheets, primitive: Int[Array, "*n"]) -> Int[Array, "*n"]:
    """The sheet of each surface; -1 for none, and for -1."""
    return jnp.where(primitive >= 0, lookup(sheets.sheet, jnp.maximum(primitive, 0)), NOTHING)
