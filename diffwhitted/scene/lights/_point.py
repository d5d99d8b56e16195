"""Point lights."""

from typing import ClassVar

import equinox as eqx
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...records import Row, changed, read_rows
from ._placed import AbstractPlacedLight, checked_clamp

LIMIT = Row(
    "attenuation_limit", "choice", "An older word for clamped: one for true, none for false.", default=None,
    choices=("one", "none"),
)  # fmt: skip


class PointLight(AbstractPlacedLight):
    """A point that shines alike in all directions.

    Its colour arrives unchanged at any distance unless `attenuation` = (a0, a1, a2) is given: then it is
    multiplied by min(1, 1 / (a0 + a1 d + a2 d**2)) (Hearn and Baker, intensity attenuation). With
    `clamped` = False it is not held at 1 near the light: (0, 0, 1) is then the inverse square everywhere.
    `attenuation_limit` = "one" or "none" is an older word for True and False; the two must not contradict each other.
    """

    TYPE: ClassVar[str] = "point"
    ROWS: ClassVar[tuple[Row, ...]] = (*AbstractPlacedLight.ROWS, LIMIT)

    position: Float[Array, "3"]
    colour: Float[Array, "3"]
    attenuation: Float[Array, "3"] | None
    clamped: bool | None = eqx.field(static=True)
    attenuation_limit: str | None = eqx.field(static=True)
    name: str | None = eqx.field(static=True)

    def __init__(
        self,
        position,
        colour,
        attenuation=None,
        name: str | None = None,
        place: str = "point light",
        attenuation_limit: str | None = None,
        clamped: bool | None = None,
    ):
        self.name, self.attenuation_limit = name, attenuation_limit
        if attenuation_limit not in (None, "one", "none"):
            raise SceneError(f'{place}: attenuation_limit = {attenuation_limit!r}; allowed is "one" or "none"')
        if attenuation_limit is not None and attenuation is None:
            raise SceneError(f"{place}: attenuation_limit without an attenuation, which it is about; give one")
        self.clamped = checked_clamp(clamped, attenuation, place)
        if attenuation_limit is not None and self.clamped is not None and self.clamped != (attenuation_limit == "one"):
            raise SceneError(
                f'{place}: attenuation_limit = "{attenuation_limit}" contradicts clamped = {str(clamped).lower()}; '
                "leave attenuation_limit out"
            )
        read_rows(self, place, position=position, colour=colour, attenuation=attenuation)

    @property
    def held(self) -> bool:
        return self.clamped is not False and self.attenuation_limit != "none"

    def without_fading(self) -> "PointLight":
        return changed(self, attenuation=None, clamped=None, attenuation_limit=None)
