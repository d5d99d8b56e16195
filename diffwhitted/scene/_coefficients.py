"""The one table of material coefficients.

Bounds of a fit, free names, report columns, file formats and gradient tests are all read from this
table: a new coefficient is one row here and one field of `Material`.
"""

from dataclasses import dataclass
from math import inf
from typing import Literal


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of a material."""

    name: str
    symbol: str
    unit: str
    coloured: bool
    """May be linear RGB (one value a channel); otherwise one number."""
    lowest: float
    """Smallest value a scene may have (inclusive)."""
    highest: float
    """Largest value a scene may have (inclusive)."""
    default: float | None
    """Value where a material does not state it; None: the value of k_s."""
    fit_bounds: tuple[float, float]
    """Interval in which a fit looks for it unless told otherwise."""
    scale: Literal["interval", "log", "log-excess"]
    """In what the unknown of a fit is linear between its bounds: value, log(value) or log(value - 1)."""
    moves_rays: bool
    """A change of it changes which way rays go."""
    meaning: str
    source: str


COEFFICIENTS: tuple[Coefficient, ...] = (
    Coefficient(
        "k_a",
        "k_a",
        "1",
        True,
        0.0,
        inf,
        0.0,
        (0.0, 1.0),
        "interval",
        False,
        "ambient reflectance",
        "Hearn and Baker (14-4)",
    ),
    Coefficient(
        "k_d", "k_d", "1", True, 0.0, inf, 0.0, (0.0, 1.0), "interval", False, "diffuse reflectance", "Whitted (1)"
    ),
    Coefficient(
        "k_h",
        "k_h",
        "1",
        True,
        0.0,
        inf,
        None,
        (0.0, 1.0),
        "interval",
        False,
        "highlight coefficient (k_s where it is not given)",
        "Parker et al. (1)",
    ),
    Coefficient(
        "k_s",
        "k_s",
        "1",
        True,
        0.0,
        inf,
        0.0,
        (0.0, 1.0),
        "interval",
        False,
        "share of light that arrives along the mirror ray",
        "Whitted (2)",
    ),
    Coefficient(
        "k_t",
        "k_t",
        "1",
        True,
        0.0,
        inf,
        0.0,
        (0.0, 1.0),
        "interval",
        False,
        "share of light that arrives along the transmitted ray",
        "Whitted (2)",
    ),
    Coefficient(
        "phong_exponent",
        "n",
        "1",
        False,
        0.0,
        inf,
        50.0,
        (1.0, 1000.0),
        "log",
        False,
        "exponent of the highlight",
        "Whitted (1)",
    ),
    Coefficient(
        "refractive_index",
        "η",
        "1",
        False,
        1.0,
        1000.0,
        1.0,
        (1.001, 4.0),
        "log-excess",
        True,
        "index of the inside against vacuum",
        "Hearn and Baker (14-50)",
    ),
)

BY_NAME: dict[str, Coefficient] = {row.name: row for row in COEFFICIENTS}
