"""Classes of materials: which coefficients each has (Parker et al. 3.1: "we break the materials into several classes
to compute only non-zero coefficients").

A new class is a row. What it does beside its coefficients is an effect's work (see `tree/_effects`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

FresnelModel = Literal["off", "exact", "schlick"]
FRESNEL: tuple[str, ...] = get_args(FresnelModel)
"""What the weights of the branches do with the angle."""

GLASS_INDEX = 1.5
"""Of a dielectric or a coat that states none."""


@dataclass(frozen=True)
class MaterialClass:
    """One row."""

    name: str
    meaning: str
    has: tuple[str, ...] | None
    """Its coefficients; None: all there are. What it has not is not computed, and is refused where it is stated."""
    fixed: Mapping[str, float] = field(default_factory=dict)
    """Values of coefficients that it has not, where they are not zero."""
    defaults: Mapping[str, float | None] = field(default_factory=dict)
    """Of coefficients that it has, in place of those of the table."""
    follows: Mapping[str, str] = field(default_factory=dict)
    """Coefficients that are always another one."""
    fresnel: tuple[str, ...] = ("off", "exact", "schlick")
    """The models that it may have, its default first."""

    def stated(self, name: str) -> bool:
        """Does it have the coefficient?"""
        return self.has is None or name in self.has


CLASSES: tuple[MaterialClass, ...] = (
    MaterialClass("whitted", "all coefficients as they are given", None),
    MaterialClass("diffuse", "k_h = k_s = k_t = 0", ("k_a", "k_d", "height_scale", "emission"), fresnel=("off",)),
    MaterialClass("metal", "k_d = k_t = 0; k_s is the reflectance at normal incidence, and k_h where none is given",
                  ("k_s", "k_h", "phong_exponent", "roughness", "height_scale", "emission"),
                  fresnel=("schlick", "off")),
    MaterialClass("dielectric", "k_s F along the mirror ray and k_t (1 - k_s F) along the transmitted one",
                  ("k_s", "k_t", "k_h", "phong_exponent", "refractive_index", "abbe_number", "extinction",
                   "roughness", "height_scale", "emission"),
                  defaults={"k_s": 1.0, "k_t": 1.0, "refractive_index": GLASS_INDEX},
                  fresnel=("exact", "schlick", "off")),
    MaterialClass("polished", "a matte surface of reflectance k_d under a smooth coat", (
                  "k_d", "k_h", "phong_exponent", "refractive_index", "roughness", "height_scale", "emission"),
                  fixed={"k_s": 1.0}, defaults={"k_h": 0.0, "refractive_index": GLASS_INDEX}, follows={"k_a": "k_d"},
                  fresnel=("schlick",)),
)  # fmt: skip
"""The classes that there are, the default first."""

CLASS_BY_NAME: Mapping[str, MaterialClass] = {row.name: row for row in CLASSES}
CLASS_NAMES: tuple[str, ...] = tuple(CLASS_BY_NAME)
