"""The Phong highlight as a rough mirror of microfacets, for programs that have no other.

An exponent n of (N.H)^n is the width alpha = sqrt(2 / (n + 2)) (Walter et al. 2007, after equation 30); (V.R)^n is
taken as (N.H)^(4 n), which is right near its top. A microfacet of reflectance F seen straight on sends back
F (n + 2) / 8 of a light at the top, so F = 8 k_h / (n + 2).
"""

import numpy as np

from ..scene import Material
from ._numbers import halfway_exponent, reflectances


def width(material: Material) -> float:
    """alpha, from 0 (a mirror) to 1."""
    return float(np.sqrt(2 / (halfway_exponent(material) + 2)))


def facet_reflectance(material: Material) -> np.ndarray:
    """F, (3,); 0 without a highlight."""
    if material.highlight == "off":
        return np.zeros(3)
    return 8 * reflectances(material)["k_h"] / (halfway_exponent(material) + 2)
