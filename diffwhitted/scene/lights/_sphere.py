"""Lamps that are balls."""

from typing import ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from ...numerics._vector import Vec3
from ...records import Row, changed, read_rows
from ._light import COLOUR, AbstractLight
from ._placed import FADE, AbstractFadingLight, checked_clamp
from ._point import PointLight
from ._spread import MOST_SAMPLES, over_ball


class SphereLight(AbstractFadingLight):
    """A ball that shines: centre and radius in metres, and the colour that arrives of all of it.

    With `samples` = 0 one ray to its middle decides how much of it is seen (Parker et al. 3.2): an occluder whose
    outline passes the ray's line at a distance m (negative: it covers the line), t metres from the point, has the half
    penumbra w = radius t / d with d the distance of the light; s = tau^2 (3 - 2 tau), tau = (m + w) / (2 w) held from 0
    to 1; of several occluders the least s counts. With n samples it is n point lights spread evenly over the ball, each
    with an n-th of the colour. Light comes from the middle, or from each of the points. It is no object: nothing sees
    it, and it hides nothing.
    """

    TYPE: ClassVar[str] = "sphere"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("centre", "vector", "Its middle, metres.", unit="m", scale="unbounded", moves="shadows"),
        Row("radius", "number", "Metres.", unit="m", lowest=0, excluded=True, scale="log", moves="shadows"),
        COLOUR,
        Row("samples", "count", f"0: one ray to its middle, and half shadows by the distance of outlines; n: n points "
            f"whose lights are added up, to {MOST_SAMPLES}.", default=0, lowest=0, highest=MOST_SAMPLES),
        *FADE,
    )  # fmt: skip

    centre: Float[Array, "3"]
    radius: Float[Array, ""]
    colour: Float[Array, "3"]
    attenuation: Float[Array, "3"] | None
    samples: int = eqx.field(static=True)
    clamped: bool | None = eqx.field(static=True)
    name: str | None = eqx.field(static=True)

    def __init__(
        self,
        centre,
        radius,
        colour,
        samples: int = 0,
        attenuation=None,
        clamped: bool | None = None,
        name: str | None = None,
        place: str = "sphere light",
    ):
        self.name, self.clamped = name, checked_clamp(clamped, attenuation, place)
        read_rows(self, place, centre=centre, radius=radius, colour=colour, samples=samples, attenuation=attenuation)

    def at(self, place, share: float = 1.0) -> PointLight:
        """A point light at one of its points, with a share of its colour."""
        return PointLight(
            place, self.colour * self.colour.dtype.type(share), self.attenuation, clamped=self.clamped, name=self.name
        )

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """As of a point at its middle."""
        return self.arriving_from(self.centre, point)

    def members(self) -> tuple[AbstractLight, ...]:
        if not self.samples:
            return (self,)
        offsets = over_ball(self.samples).astype(self.centre.dtype)
        return tuple(self.at(self.centre + self.radius * offset, 1 / self.samples) for offset in offsets)

    def ball_radius(self) -> Float[Array, ""] | None:
        return None if self.samples else self.radius

    def without_size(self) -> PointLight:
        return self.at(self.centre)

    def sampled(self, samples: int) -> "SphereLight":
        return changed(self, samples=samples)

    def place(self) -> np.ndarray:
        return np.asarray(self.centre, np.float64)
