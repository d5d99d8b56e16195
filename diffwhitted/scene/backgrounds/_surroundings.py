"""How what is around a scene lights a surface: the mean of it about a direction, weighted by a power of the cosine."""

import equinox as eqx
from jaxtyping import Array, Bool, Float

from ...numerics._vector import Vec3
from ._lobes import Lobes
from ._spherical_harmonics import degree_of, lobe_shares, summed, summed_with


class Surroundings(eqx.Module):
    """The light of a background on surfaces, for the ray tree. Nothing stands in its way."""

    coefficients: Float[Array, "count 3"]
    """Of real spherical harmonics, linear RGB."""
    lobes: Lobes | None
    """A map, weighted by cos^n for some n; None: the harmonics are all that there is."""
    shiny: Bool[Array, "materials"]
    """Does the material state a k_h?"""

    def mean(self, normal: Vec3) -> Vec3:
        """E / pi of a surface: the mean of the radiance, weighted by N.w, exact for what the harmonics hold."""
        shares = lobe_shares(1.0, degree_of(self.coefficients.shape[0]))
        return summed(self.coefficients, normal, shares)

    def lobe(self, direction: Vec3, exponent: Float[Array, "*n"]) -> Vec3:
        """(n + 1) / (2 pi) times the integral of L(w) max(R.w, 0)^n over all directions w.

        Exact for harmonics, differentiable in R and n; see `Lobes` for maps.
        """
        if self.lobes is not None:
            return self.lobes.at(direction, exponent)
        shares = lobe_shares(exponent, degree_of(self.coefficients.shape[0]))
        return summed_with(self.coefficients, direction, shares)
