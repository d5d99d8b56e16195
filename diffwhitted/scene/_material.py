"""What a surface is made of."""

from typing import Any, Literal, get_args

import equinox as eqx
from jaxtyping import Array, Float

from .._errors import SceneError
from ..records import number_array, require
from ._coefficients import BY_NAME, coefficients

HighlightModel = Literal["halfway", "reflected", "off"]
HIGHLIGHTS: tuple[str, ...] = get_args(HighlightModel)
TEXTURE = "_texture"
"""COEFFICIENT_texture names the texture that multiplies a coefficient."""


class Material(eqx.Module):
    """Coefficients of one material; each a number or, where the table allows it, linear RGB.

    Its coefficients are attributes (`material.k_d`), and so are the names of their textures (`material.k_d_texture`,
    None without one). A k_h that is None follows k_s, also through a derivative. The table of units, bounds and
    sources is `diffwhitted.COEFFICIENTS`. Raises `SceneError` for a value outside its interval.
    """

    values: dict[str, Float[Array, ""] | Float[Array, "3"] | None]
    """By the names of the table."""
    highlight: HighlightModel = eqx.field(static=True)
    textures: tuple[tuple[str, str], ...] = eqx.field(static=True)
    """(coefficient, name of its texture), of those that have one."""

    def __init__(self, *, highlight: HighlightModel = "halfway", place: str = "material", **stated):
        textures = {key: stated.pop(key) for key in list(stated) if key.endswith(TEXTURE) and key not in BY_NAME}
        unknown = sorted({*stated} - {*BY_NAME}) + sorted({*textures} - {row.name + TEXTURE for row in textured_rows()})
        if unknown:
            raise TypeError(f"{place}: unknown coefficient {unknown[0]!r}; there are {', '.join(BY_NAME)}")
        values = {row.name: stated.get(row.name, row.default) for row in coefficients()}
        self.values = {name: None if value is None else checked(name, value, place) for name, value in values.items()}
        if highlight not in HIGHLIGHTS:
            raise SceneError(f"{place}: highlight = {highlight!r}; allowed is {', '.join(HIGHLIGHTS)}")
        self.highlight = highlight
        self.textures = tuple((key.removesuffix(TEXTURE), name) for key, name in textures.items() if name is not None)

    def __getattr__(self, name: str):
        values = object.__getattribute__(self, "__dict__").get("values", {})
        if name in values:
            return values[name]
        if name.endswith(TEXTURE) and name.removesuffix(TEXTURE) in values:
            return dict(self.textures).get(name.removesuffix(TEXTURE))
        raise AttributeError(f"a material has no {name!r}; there are {', '.join(values)}")

    def highlight_coefficient(self):
        """k_h, or k_s where k_h is not given (Parker et al., after equation 1)."""
        return self.values["k_s"] if self.values["k_h"] is None else self.values["k_h"]

    def at_work(self, name: str) -> Any:
        """The value of a coefficient as light sees it: an absent k_h is k_s."""
        return self.highlight_coefficient() if name == "k_h" else self.values[name]


def textured_rows():
    """The coefficients that may have a texture: all that do not move rays."""
    return tuple(row for row in coefficients() if row.coloured)


def checked(name: str, value, place: str) -> Any:
    """The value of a coefficient as an array, or `SceneError` naming the place and the interval."""
    row = BY_NAME[name]
    array = number_array(value, place, name, ((), (3,)) if row.coloured else ((),))
    require(row.holds, place, name, array, row.allowed(), row.advice(array))
    return array
