"""Lamps that are rectangles."""

from typing import ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._vector import Vec3
from ...records import Row, changed, is_traced, read_rows, shifted
from ._light import COLOUR, AbstractLight
from ._placed import FADE, AbstractFadingLight, checked_clamp
from ._point import PointLight
from ._spread import MOST_SAMPLES, over_square


class RectangleLight(AbstractFadingLight):
    """A parallelogram that shines to both sides: a corner and its two edges in metres, and the colour that arrives of
    all of it.

    It is `samples` point lights spread evenly over it, each with that part of the colour. There is no cosine at the
    lamp, and no fade but by `attenuation`. It is no object: nothing sees it, and it hides nothing.
    """

    TYPE: ClassVar[str] = "rectangle"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("corner", "vector", "One of its corners, metres.", unit="m", scale="unbounded", moves="shadows"),
        Row("edge_u", "vector", "From there to the next corner, metres.", unit="m", nonzero=True, scale="unbounded",
            moves="shadows"),
        Row("edge_v", "vector", "From there to the corner before, metres.", unit="m", nonzero=True, scale="unbounded",
            moves="shadows"),
        COLOUR,
        Row("samples", "count", f"Points whose lights are added up, 1 to {MOST_SAMPLES}.", default=16, lowest=1,
            highest=MOST_SAMPLES),
        *FADE,
    )  # fmt: skip

    corner: Float[Array, "3"]
    edge_u: Float[Array, "3"]
    edge_v: Float[Array, "3"]
    colour: Float[Array, "3"]
    attenuation: Float[Array, "3"] | None
    samples: int = eqx.field(static=True)
    clamped: bool | None = eqx.field(static=True)
    name: str | None = eqx.field(static=True)

    def __init__(
        self,
        corner,
        edge_u,
        edge_v,
        colour,
        samples: int = 16,
        attenuation=None,
        clamped: bool | None = None,
        name: str | None = None,
        place: str = "rectangle light",
    ):
        self.name, self.clamped = name, checked_clamp(clamped, attenuation, place)
        read_rows(
            self,
            place,
            corner=corner,
            edge_u=edge_u,
            edge_v=edge_v,
            colour=colour,
            samples=samples,
            attenuation=attenuation,
        )
        if is_traced(self.edge_u) or is_traced(self.edge_v):
            return
        if not np.cross(np.asarray(self.edge_u, np.float64), np.asarray(self.edge_v, np.float64)).any():
            raise SceneError(f"{place}: edge_u and edge_v lie along one line; allowed are two edges of a parallelogram")

    def at(self, u: float, v: float, share: float = 1.0) -> PointLight:
        """A point light at a place of it, u and v from 0 to 1, with a share of its colour."""
        u, v, share = (self.colour.dtype.type(x) for x in (u, v, share))
        place = self.corner + self.edge_u * u + self.edge_v * v
        return PointLight(place, self.colour * share, self.attenuation, clamped=self.clamped, name=self.name)

    def arriving(self, point: Vec3) -> tuple[Vec3, Float[Array, "*n"], Vec3]:
        """As of a point in its middle."""
        return self.arriving_from(self.corner + 0.5 * (self.edge_u + self.edge_v), point)

    def members(self) -> tuple[AbstractLight, ...]:
        return tuple(self.at(u, v, 1 / self.samples) for u, v in over_square(self.samples))

    def without_size(self) -> PointLight:
        return self.at(0.5, 0.5)

    def sampled(self, samples: int) -> "RectangleLight":
        return changed(self, samples=max(samples, 1))

    def moved(self, by: np.ndarray) -> "RectangleLight":
        return changed(self, corner=shifted(self.corner, by))

    def place(self) -> np.ndarray:
        corner, u, v = (np.asarray(x, np.float64) for x in (self.corner, self.edge_u, self.edge_v))
        return corner + 0.5 * (u + v)
