"""Refractive indices of known substances at the lines C, d, F and g, and a three-term Cauchy through them.

Evaluated from the dispersion models of the database refractiveindex.info (CC0).
"""

import numpy as np
from jaxtyping import Float

from ._spectrum import LINE_C, LINE_D, LINE_F, LINE_G

LINES = LINE_C, LINE_D, LINE_F, LINE_G

CATALOGUE: dict[tuple[str, ...], tuple[float, ...]] = {
    ("N-BK7", "BK7"): (1.514322, 1.516800, 1.522376, 1.526685),
    ("fused silica",): (1.456367, 1.458464, 1.463126, 1.466693),
    ("soda-lime glass",): (1.520834, 1.523382, 1.529016, 1.533256),
    ("N-SF10", "SF10"): (1.720906, 1.728277, 1.746431, 1.761914),
    ("N-SF11", "SF11"): (1.775955, 1.784720, 1.806513, 1.825325),
    ("water",): (1.331513, 1.333403, 1.337492, 1.340586),
    ("diamond",): (2.409906, 2.417486, 2.435538, 2.449965),
    ("sapphire",): (1.764884, 1.768172, 1.775508, 1.781126),
    ("quartz",): (1.541854, 1.544276, 1.549664, 1.553782),
    ("PMMA", "acrylic"): (1.487878, 1.490618, 1.497105),
    ("polycarbonate",): (1.578607, 1.584763, 1.599598),
    ("polystyrene",): (1.585747, 1.591630, 1.605781),
    ("ethanol",): (1.359863, 1.361682, 1.365956),
    ("benzene",): (1.491130, 1.495750, 1.507448),
    ("acetone",): (1.357218, 1.359157, 1.363813),
    ("sodium chloride",): (1.540464, 1.544207, 1.553153, 1.560351),
    ("potassium chloride",): (1.487123, 1.490372, 1.498170, 1.504473),
    ("fluorite", "CaF2"): (1.432458, 1.433849, 1.437025, 1.439485),
    ("rutile",): (2.570923, 2.614265, 2.734501, 2.852918),
    ("cubic zirconia",): (2.148599, 2.158769, 2.183147, 2.203016),
}
"""Names, and n_C, n_d, n_F, n_g; of crystals with two indices the ordinary one, of liquids at 20 C."""

CATALOGUE_NAMES: tuple[str, ...] = tuple(name for names in CATALOGUE for name in names)


def catalogue_lines(name: str) -> tuple[float, ...] | None:
    """n_C, n_d, n_F, n_g of a substance, whatever the case of its name; None of one that is not there."""
    plain = name.strip().lower()
    return next((lines for names, lines in CATALOGUE.items() if plain in [one.lower() for one in names]), None)


def cauchy_through(lines: tuple[float, ...]) -> Float[np.ndarray, "3"]:
    """A, B, C of n = A + B / λ² + C / λ⁴ by least squares at C, d, F and g, λ in micrometres.

    Where n_g is not known, exactly through the other three. It meets glasses and water to 1e-4.
    """
    terms = np.stack([np.asarray(LINES[: len(lines)]) ** (-2 * k) for k in range(3)], axis=1)
    return np.linalg.lstsq(terms, np.asarray(lines), rcond=None)[0]
