"""What lamps that shine one way have in common: a lobe about their axis, and a cone."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._safe import normalise, power_of_cosine, rescaled
from ...numerics._vector import Vec3, dot, vec3
from ...records import Row, changed, is_traced
from ._border import Border, Borders
from ._placed import AbstractPlacedLight

LOBE = Row(
    "exponent", "number", "The colour is multiplied by cos^exponent of the angle to the axis. Default: 0, the same all "
    "around.", default=None, lowest=0, fit_bounds=(0.0, 100.0),
)  # fmt: skip
CONE: tuple[Row, ...] = (
    Row("inner_cone_deg", "number", "Half angle of the cone that has all of the light; from there to cone_deg it falls "
        "off by s^2 (3 - 2 s), s linear in the cosine. Default: cone_deg, a hard border.", unit="deg", default=None,
        lowest=0, highest=180, moves="patterns"),
    Row("cone_deg", "number", "Half angle of the cone beyond which there is no light. Default: no cone.", unit="deg",
        default=None, lowest=0, highest=180, excluded=True, moves="patterns"),
)  # fmt: skip


class AbstractDirectedLight(AbstractPlacedLight):
    """A lamp with an axis: colour cos^exponent within a cone. After Warn 1983, Lighting controls for synthetic images,
    equation 1, and its cones. Behind it (cos < 0) there is no light unless the exponent is 0.
    """

    exponent: eqx.AbstractVar[Float[Array, ""] | None]
    inner_cone_deg: eqx.AbstractVar[Float[Array, ""] | None]
    cone_deg: eqx.AbstractVar[Float[Array, ""] | None]
    direction: eqx.AbstractVar[Float[Array, "3"] | None]

    def axis(self) -> Vec3:
        """The unit vector along which it shines most."""
        direction = self.direction
        assert direction is not None
        return normalise(rescaled(vec3(direction))[0])

    def shone(self, to_light: Vec3) -> Vec3:
        if self.exponent is None:
            return vec3(self.colour)
        apart = to_light + self.axis()
        return vec3(self.colour) * power_of_cosine(dot(apart, apart), self.exponent)

    def borders(self, point: Vec3) -> Borders:
        if self.cone_deg is None:
            return ()
        away = normalise(rescaled(point - vec3(self.position))[0])
        outer = _cosine(self.cone_deg)
        width = None if self.inner_cone_deg is None else _cosine(self.inner_cone_deg) - outer
        return ((Border(dot(away, self.axis()) - outer, width),),)

    @property
    def bordered(self) -> bool:
        return self.cone_deg is not None

    def without_borders(self):
        return changed(self, inner_cone_deg=None, cone_deg=None)


def check_cone(place: str, inner, outer) -> None:
    """Raise `SceneError` for an inner cone without an outer one, or wider than that."""
    if inner is None:
        return
    if outer is None:
        raise SceneError(f"{place}: inner_cone_deg without a cone_deg, up to which the light falls off; give one")
    if not is_traced(inner) and not is_traced(outer) and np.asarray(inner) > np.asarray(outer):
        raise SceneError(
            f"{place}: inner_cone_deg = {float(inner):g}; allowed is up to cone_deg = {float(outer):g}. Both are half "
            "angles, from the axis to the border"
        )


def _cosine(degrees):
    return jnp.cos(jnp.asarray(degrees) * (jnp.pi / 180))
