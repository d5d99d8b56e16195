"""Spotlights."""

from typing import ClassVar

import equinox as eqx
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._safe import normalise, rescaled
from ...numerics._vector import Vec3, vec3
from ...records import Row, read_rows, require
from ._directed import CONE, LOBE, AbstractDirectedLight, check_cone
from ._light import COLOUR
from ._placed import FADE, POSITION, checked_clamp


class SpotLight(AbstractDirectedLight):
    """A lamp with a cone: it shines along `direction`, or towards `look_at`; one of the two is given.

    Its colour is multiplied by cos^`exponent` of the angle to the axis. Within the half angle `inner_cone_deg` it has
    all of that, beyond `cone_deg` nothing; between them it falls off by s^2 (3 - 2 s), s linear in the cosine. It fades
    by `attenuation` and `clamped` as a point light does.
    """

    TYPE: ClassVar[str] = "spot"
    ROWS: ClassVar[tuple[Row, ...]] = (
        POSITION,
        Row("look_at", "vector", "The point on its axis that it shines at, metres; in place of direction.", unit="m",
            default=None, scale="unbounded", moves="patterns", freedom="turn", about="position"),
        Row("direction", "direction", "The way it shines; any length but zero. In place of look_at.", default=None,
            nonzero=True, scale="unbounded", moves="patterns"),
        COLOUR,
        LOBE,
        *CONE,
        *FADE,
    )  # fmt: skip

    position: Float[Array, "3"]
    colour: Float[Array, "3"]
    look_at: Float[Array, "3"] | None
    direction: Float[Array, "3"] | None
    exponent: Float[Array, ""] | None
    inner_cone_deg: Float[Array, ""] | None
    cone_deg: Float[Array, ""] | None
    attenuation: Float[Array, "3"] | None
    clamped: bool | None = eqx.field(static=True)
    name: str | None = eqx.field(static=True)

    def __init__(
        self,
        position,
        colour,
        look_at=None,
        direction=None,
        exponent=None,
        inner_cone_deg=None,
        cone_deg=None,
        attenuation=None,
        clamped: bool | None = None,
        name: str | None = None,
        place: str = "spot light",
    ):
        self.name, self.clamped = name, checked_clamp(clamped, attenuation, place)
        if (look_at is None) == (direction is None):
            both = "look_at and direction" if direction is not None else "neither look_at nor direction"
            raise SceneError(f"{place}: {both}; allowed is one of the two, which says where it shines")
        read_rows(
            self,
            place,
            position=position,
            look_at=look_at,
            direction=direction,
            colour=colour,
            exponent=exponent,
            inner_cone_deg=inner_cone_deg,
            cone_deg=cone_deg,
            attenuation=attenuation,
        )
        check_cone(place, self.inner_cone_deg, self.cone_deg)
        if self.look_at is not None:
            require(lambda at: (at != position).any(), place, "look_at", self.look_at, "any point but its position")

    def axis(self) -> Vec3:
        if self.look_at is None:
            return super().axis()
        return normalise(rescaled(vec3(self.look_at) - vec3(self.position))[0])
