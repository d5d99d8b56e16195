"""Cones, whole or cut off."""

from collections.abc import Sequence
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import AbstractSurfaces
from ..numerics._safe import length, normalise, safe_divide
from ..numerics._vector import vec3
from ..records import Row, is_traced, listed, read_rows
from ._frusta import Frusta
from ._object import AbstractObject

BASE = Row("base", "vector", "Middle of the lower end, metres.", unit="m", scale="unbounded", moves="rays")
TOP = Row("top", "vector", "Middle of the upper end, metres.", unit="m", scale="unbounded", moves="rays")
CAPPED = Row("capped", "flag", "Closed by discs at its ends; else an open tube.", default=True)


class Cone(AbstractObject):
    """A cone, or what is left of one cut off square to its axis: the middles of its ends and the radii there, metres.

    One of the radii may be 0. Capped it is a solid; else a sheet, whose inner side is that of the axis. Raises
    `SceneError` where base and top are one point, or both radii 0.
    """

    TYPE: ClassVar[str] = "cone"
    ROWS: ClassVar[tuple[Row, ...]] = (
        BASE,
        TOP,
        Row("base_radius", "number", "Radius of the lower end, metres.", unit="m", lowest=0, moves="rays"),
        Row("top_radius", "number", "Radius of the upper end, metres; 0 for a point.", unit="m", lowest=0,
            moves="rays"),
        CAPPED,
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Frusta
    CONVEX: ClassVar[bool] = True

    base: Float[Array, "3"]
    top: Float[Array, "3"]
    base_radius: Float[Array, ""]
    top_radius: Float[Array, ""]
    capped: bool = eqx.field(static=True)
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(
        self, name: str, base, top, base_radius, top_radius, material: str, capped=True, place: str | None = None
    ):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        read_rows(self, place, base=base, top=top, base_radius=base_radius, top_radius=top_radius, capped=capped)
        check_ends(self.base, self.top, place)
        radii = self.base_radius, self.top_radius
        if not any(map(is_traced, radii)) and not np.any(radii):
            raise SceneError(f"{place}: base_radius and top_radius are both 0; allowed is 0 for one of them")

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """The numbers, and which of them are capped."""
        capped = np.asarray([thing.capped for thing in objects])
        return [*super().columns(objects), jnp.asarray(capped)]

    @classmethod
    def family(cls, base, top, base_radius, top_radius, capped) -> Frusta:
        return frusta(base, top, base_radius, top_radius, capped)

    def is_convex(self) -> bool:
        return self.capped

    def ball(self) -> tuple[np.ndarray, float]:
        return ball_of_ends(self.base, self.top, max(float(self.base_radius), float(self.top_radius)))


def frusta(base, top, base_radius, top_radius, capped) -> Frusta:
    """The family by ends and radii; differentiable."""
    start, way = vec3(base), vec3(top) - vec3(base)
    half = 0.5 * length(way)
    return Frusta(
        start + way * 0.5,
        normalise(way),
        half,
        0.5 * (base_radius + top_radius),
        safe_divide(0.5 * (top_radius - base_radius), half),
        capped,
    )


def check_ends(base, top, place: str) -> None:
    """Raise `SceneError` where the ends are one point."""
    if not is_traced(base) and not is_traced(top) and np.array_equal(base, top):
        raise SceneError(f"{place}: top = {listed(top)} is base; allowed is any other point. For a disc, use type = "
                         '"disc"')  # fmt: skip


def ball_of_ends(base, top, radius: float) -> tuple[np.ndarray, float]:
    """Middle (3,) and radius of a sphere around a frustum whose larger end has a radius."""
    base, top = np.asarray(base, np.float64), np.asarray(top, np.float64)
    return (base + top) / 2, float(np.hypot(np.linalg.norm(top - base) / 2, radius))
