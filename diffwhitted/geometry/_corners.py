"""What a surface knows at its corners, from which light is interpolated: places, normals, and a point's shares."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..numerics._safe import normalise, safe_divide, safe_sqrt
from ..numerics._vector import Vec3, dot, where
from ._search import Shapes
from ._surface import Shares, Three


class Corners(eqx.Module):
    """The corners of the triangle that a ray met. Finite also where it met something else, and of no meaning there."""

    places: Three
    normals: Three
    """Unit normals, on the side of the ray."""
    shares: Shares
    """The barycentric coordinates of the point."""

    def near_normal(self) -> Vec3:
        """N/|N| of the interpolated N as its Taylor series of second order about the middle of the triangle, not of
        unit length.

        N = A x + B y + C (Hearn and Baker 14-43), with C the mean of the corners' normals and x, y counted from the
        middle; with D = A x + B y, g = C.D / C.C and d = D.D / C.C it is
        (C (1 - g - d/2 + 3/2 g**2) + D (1 - g)) / |C|: L times it is the polynomial in x and y that (14-45) becomes.
        Edge: where the three normals cancel out it is 0, with derivative 0.
        """
        first, second, third = self.normals
        middle = (first + second + third) * (1 / 3)
        apart = first * self.shares[0] + second * self.shares[1] + third * self.shares[2] - middle
        square = dot(middle, middle)
        along, aside = (safe_divide(dot(apart, v), square) for v in (middle, apart))
        series = middle * (1 - along - 0.5 * aside + 1.5 * along * along) + apart * (1 - along)
        return series * safe_divide(1, safe_sqrt(square))


def corners_at(shapes: Shapes, primitive: Int[Array, "n"], point: Vec3, entering: Bool[Array, "n"]) -> Corners:
    """The corners of the known surfaces that points lie on, differentiable; zeros for surfaces without corners."""
    zero = jnp.zeros_like(point.x)
    nothing = Vec3(zero, zero, zero)
    found = Corners((nothing, nothing, nothing), (nothing, nothing, nothing), (zero, zero, zero))
    for mine, member in shapes.members(primitive):
        if member.interpolated:
            places, normals, shares = member.corners_of(point)
            first, second, third = (where(entering, normal, -normal) for normal in map(normalise, normals))
            found = where(mine, Corners(places, (first, second, third), shares), found)
    return found
