"""The one table of material coefficients.

Bounds of a fit, free names, report columns, file formats and gradient tests are all read from this
table: a new coefficient is one row here, and its work is that of an effect (see `tree/_effects`).
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import inf

from ..records import Row

COEFFICIENTS: tuple[Row, ...] = (
    Row("k_a", "number or colour", "ambient reflectance", symbol="k_a", default=0.0, lowest=0.0, highest=inf,
        fit_bounds=(0.0, 1.0), source="Hearn and Baker (14-4)"),
    Row("k_d", "number or colour", "diffuse reflectance", symbol="k_d", default=0.0, lowest=0.0, highest=inf,
        fit_bounds=(0.0, 1.0), source="Whitted (1)"),
    Row("k_h", "number or colour", "highlight coefficient (k_s where it is not given)", symbol="k_h", default=None,
        lowest=0.0, highest=inf, fit_bounds=(0.0, 1.0), source="Parker et al. (1)"),
    Row("k_s", "number or colour", "share of light that arrives along the mirror ray", symbol="k_s", default=0.0,
        lowest=0.0, highest=inf, fit_bounds=(0.0, 1.0), source="Whitted (2)"),
    Row("k_t", "number or colour", "share of light that arrives along the transmitted ray", symbol="k_t", default=0.0,
        lowest=0.0, highest=inf, fit_bounds=(0.0, 1.0), source="Whitted (2)"),
    Row("phong_exponent", "number", "exponent of the highlight", symbol="n", default=50.0, lowest=0.0, highest=inf,
        fit_bounds=(1.0, 1e6), scale="log", source="Whitted (1)"),
    Row("refractive_index", "number", "index of the inside against vacuum", symbol="η", default=1.0, lowest=1.0,
        highest=1000.0, fit_bounds=(1.001, 4.0), scale="log-excess", moves="rays", source="Hearn and Baker (14-50)",
        below="For a bubble put a sphere of index 1 inside the glass; to look at air from under water put the camera "
        "inside the water"),
    Row("extinction", "number or colour", "light is multiplied by exp(-extinction d) on d metres inside", unit="1/m",
        symbol="a", default=0.0, lowest=0.0, highest=inf, fit_bounds=(0.0, 1000.0), textured=False,
        source="Parker et al. 3.1"),
    Row("abbe_number", "number", "(n_d - 1) / (n_F - n_C), of the index by wavelength; 0 for none", symbol="V",
        default=0.0, lowest=0.0, highest=inf, fit_bounds=(5.0, 500.0), scale="log", moves="rays",
        source="two-term Cauchy"),
    Row("roughness", "number", "standard deviation of the slopes of a rough surface, along each axis", symbol="σ",
        default=0.0, lowest=0.0, highest=inf, fit_bounds=(0.0, 0.5), moves="rays", source="Whitted 1980, section 2"),
    Row("height_scale", "number", "height of a height_texture where it is 1", unit="m", symbol="h", default=0.0,
        lowest=0.0, highest=inf, fit_bounds=(0.0, 1.0), moves="rays", source="Blinn 1978",
        below="For dents in place of bumps exchange the two colours of the texture"),
    Row("emission", "number or colour", "radiance that the surface sends out of its own, alike to all sides",
        symbol="L_e", default=0.0, lowest=0.0, highest=inf, fit_bounds=(0.0, 1000.0),
        source="Hearn and Baker (14-74)"),
)  # fmt: skip
"""The coefficients that the package has."""

SWITCHED: tuple[str, ...] = ("abbe_number", "roughness", "height_scale", "emission")
"""Those that a material has only where one is stated that is not zero: scenes that state none are to cost what they
did."""

_added: list[Row] = []


def coefficients() -> tuple[Row, ...]:
    """All coefficients: those of the package and those that were added."""
    return (*COEFFICIENTS, *_added)


@contextmanager
def including_coefficient(row: Row) -> Iterator[Row]:
    """The table with one row more, for the length of a `with` block."""
    _added.append(row)
    try:
        yield row
    finally:
        _added.remove(row)


class _ByName(Mapping[str, Row]):
    """The table by name."""

    def __getitem__(self, name: str) -> Row:
        for row in coefficients():
            if row.name == name:
                return row
        raise KeyError(name)

    def __iter__(self):
        return (row.name for row in coefficients())

    def __len__(self) -> int:
        return len(coefficients())


BY_NAME: Mapping[str, Row] = _ByName()
