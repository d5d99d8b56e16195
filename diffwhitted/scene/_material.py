"""What a surface is made of."""

from math import isfinite
from typing import Literal, get_args

import equinox as eqx
from jaxtyping import Array, Float

from .._errors import SceneError
from ._checks import number_array, require
from ._coefficients import BY_NAME, COEFFICIENTS

HighlightModel = Literal["halfway", "reflected", "off"]


class Material(eqx.Module):
    """Coefficients of one material; each a number or, where the table allows it, linear RGB.

    A k_h that is None follows k_s, also through a derivative. The table of units, bounds and sources is
    `diffwhitted.COEFFICIENTS`. Raises `SceneError` for a value outside its interval.
    """

    k_a: Float[Array, ""] | Float[Array, "3"]
    k_d: Float[Array, ""] | Float[Array, "3"]
    k_h: Float[Array, ""] | Float[Array, "3"] | None
    k_s: Float[Array, ""] | Float[Array, "3"]
    k_t: Float[Array, ""] | Float[Array, "3"]
    phong_exponent: Float[Array, ""]
    refractive_index: Float[Array, ""]
    highlight: HighlightModel = eqx.field(static=True)
    k_a_texture: str | None = eqx.field(static=True)
    k_d_texture: str | None = eqx.field(static=True)

    def __init__(
        self,
        *,
        highlight: HighlightModel = "halfway",
        k_a_texture: str | None = None,
        k_d_texture: str | None = None,
        place: str = "material",
        **coefficients,
    ):
        unknown = set(coefficients) - set(BY_NAME)
        if unknown:
            raise TypeError(f"{place}: unknown coefficient {sorted(unknown)[0]!r}; there are {', '.join(BY_NAME)}")
        for row in COEFFICIENTS:
            value = coefficients.get(row.name, row.default)
            setattr(self, row.name, None if value is None else checked(row.name, value, place))
        if highlight not in get_args(HighlightModel):
            raise SceneError(f"{place}: highlight = {highlight!r}; allowed is {', '.join(get_args(HighlightModel))}")
        self.highlight, self.k_a_texture, self.k_d_texture = highlight, k_a_texture, k_d_texture

    def highlight_coefficient(self):
        """k_h, or k_s where k_h is not given (Parker et al., after equation 1)."""
        return self.k_s if self.k_h is None else self.k_h


def checked(name: str, value, place: str):
    """The value of a coefficient as an array, or `SceneError` naming the place and the interval."""
    row = BY_NAME[name]
    array = number_array(value, place, name, ((), (3,)) if row.coloured else ((),))
    allowed = f">= {row.lowest:g}" + (f" and <= {row.highest:g}" if isfinite(row.highest) else "")
    require(lambda v: ((v >= row.lowest) & (v <= row.highest)).all(), place, name, array, allowed)
    return array
