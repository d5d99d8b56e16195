"""Warn's lights: a lobe, a cone, and flaps along the axes."""

from typing import ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._vector import Vec3
from ...records import Row, changed, is_traced, listed, read_rows
from ._border import Border, Borders
from ._directed import CONE, LOBE, AbstractDirectedLight, check_cone
from ._light import COLOUR
from ._placed import FADE, POSITION, checked_clamp

AXES = ("x", "y", "z")


def _flap(axis: str) -> Row:
    return Row(
        f"flaps_{axis}",
        "numbers",
        f"A point p is lit where lo <= (p - position).{axis} <= hi, metres. Default: no flaps along {axis}.",
        unit="m",
        default=None,
        scale="unbounded",
        moves="patterns",
        parts=("lo", "hi"),
        table="flaps",
    )


class WarnLight(AbstractDirectedLight):
    """The lamp of Warn 1983, Lighting controls for synthetic images: it shines along `direction` with cos^`exponent`.

    `flaps_x`, `flaps_y`, `flaps_z`, each (lo, hi) or None, are metres from the light: a point p is lit where lo <=
    (p - position).x <= hi, and likewise along the other axes. `inner_cone_deg` and `cone_deg` are those of a spot
    light; it fades by `attenuation` and `clamped` as a point light does.
    """

    TYPE: ClassVar[str] = "warn"
    ROWS: ClassVar[tuple[Row, ...]] = (
        POSITION,
        Row("direction", "direction", "The way it shines; any length but zero.", nonzero=True, scale="unbounded",
            moves="patterns"),
        COLOUR,
        LOBE,
        *map(_flap, AXES),
        *CONE,
        *FADE,
    )  # fmt: skip

    position: Float[Array, "3"]
    direction: Float[Array, "3"]
    colour: Float[Array, "3"]
    exponent: Float[Array, ""] | None
    flaps_x: Float[Array, "2"] | None
    flaps_y: Float[Array, "2"] | None
    flaps_z: Float[Array, "2"] | None
    inner_cone_deg: Float[Array, ""] | None
    cone_deg: Float[Array, ""] | None
    attenuation: Float[Array, "3"] | None
    clamped: bool | None = eqx.field(static=True)
    name: str | None = eqx.field(static=True)

    def __init__(
        self,
        position,
        direction,
        colour,
        exponent=None,
        flaps_x=None,
        flaps_y=None,
        flaps_z=None,
        inner_cone_deg=None,
        cone_deg=None,
        attenuation=None,
        clamped: bool | None = None,
        name: str | None = None,
        place: str = "warn light",
    ):
        self.name, self.clamped = name, checked_clamp(clamped, attenuation, place)
        read_rows(
            self,
            place,
            position=position,
            direction=direction,
            colour=colour,
            exponent=exponent,
            flaps_x=flaps_x,
            flaps_y=flaps_y,
            flaps_z=flaps_z,
            inner_cone_deg=inner_cone_deg,
            cone_deg=cone_deg,
            attenuation=attenuation,
        )
        check_cone(place, self.inner_cone_deg, self.cone_deg)
        for axis, flaps in self._flaps():
            if not is_traced(flaps) and not np.asarray(flaps)[0] < np.asarray(flaps)[1]:
                raise SceneError(f"{place}: flaps: {axis} = {listed(flaps)}; allowed is [lo, hi] with lo < hi")

    def _flaps(self):
        return [(axis, flaps) for axis in AXES if (flaps := getattr(self, f"flaps_{axis}")) is not None]

    def borders(self, point: Vec3) -> Borders:
        pairs = []
        for number, axis in enumerate(AXES):
            flaps = getattr(self, f"flaps_{axis}")
            if flaps is not None:
                offset = getattr(point, axis) - self.position[..., number]
                pairs.append((Border(offset - flaps[..., 0]), Border(flaps[..., 1] - offset)))
        return (*super().borders(point), *pairs)

    @property
    def bordered(self) -> bool:
        return self.cone_deg is not None or bool(self._flaps())

    def without_borders(self) -> "WarnLight":
        return changed(self, inner_cone_deg=None, cone_deg=None, flaps_x=None, flaps_y=None, flaps_z=None)
