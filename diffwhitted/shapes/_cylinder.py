"""Cylinders."""

from collections.abc import Sequence
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..geometry import AbstractSurfaces
from ..records import Row, is_traced, listed, read_rows, stacked
from ._cone import BASE, CAPPED, TOP, ball_of_ends, check_ends, frusta
from ._frusta import Frusta
from ._object import AbstractObject


class Cylinder(AbstractObject):
    """A circular cylinder: the middles of its ends and its radius, metres.

    Files may state `base_radius` and `top_radius`, which are one number, in place of `radius`. Capped it is a solid;
    else a tube, whose inner side is that of the axis. Raises `SceneError` where base and top are one point, and where
    the radii differ.
    """

    TYPE: ClassVar[str] = "cylinder"
    ROWS: ClassVar[tuple[Row, ...]] = (
        BASE,
        TOP,
        Row("radius", "number", "Radius, metres.", unit="m", default=None, lowest=0, excluded=True, scale="log",
            moves="rays"),
        CAPPED,
        Row("base_radius", "number", "With top_radius, in place of radius: the same number twice.", unit="m",
            default=None, scale="unbounded", moves="rays"),
        Row("top_radius", "number", "See base_radius.", unit="m", default=None, scale="unbounded", moves="rays"),
    )  # fmt: skip
    FAMILY: ClassVar[type[AbstractSurfaces]] = Frusta
    CONVEX: ClassVar[bool] = True

    base: Float[Array, "3"]
    top: Float[Array, "3"]
    radius: Float[Array, ""]
    base_radius: None
    top_radius: None
    capped: bool = eqx.field(static=True)
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(
        self,
        name: str,
        base,
        top,
        radius=None,
        material: str = "",
        capped=True,
        base_radius=None,
        top_radius=None,
        place: str | None = None,
    ):
        place = place or f"object {name!r}"
        self.name, self.material = name, material
        self.base_radius = self.top_radius = None
        radius = _one_radius(radius, base_radius, top_radius, place)
        read_rows(self, place, base=base, top=top, radius=radius, capped=capped)
        check_ends(self.base, self.top, place)

    @classmethod
    def columns(cls, objects: Sequence[Any]) -> list:
        """Ends, radii, and which of them are capped."""
        numbers = [stacked([getattr(thing, key) for thing in objects]) for key in ("base", "top", "radius")]
        return [*numbers, jnp.asarray(np.asarray([thing.capped for thing in objects]))]

    @classmethod
    def family(cls, base, top, radius, capped) -> Frusta:
        return frusta(base, top, radius, radius, capped)

    def is_convex(self) -> bool:
        return self.capped

    def ball(self) -> tuple[np.ndarray, float]:
        return ball_of_ends(self.base, self.top, float(self.radius))


def _one_radius(radius, base_radius, top_radius, place: str):
    """The radius, from whichever way it is stated."""
    ends = [end for end in (base_radius, top_radius) if end is not None]
    if radius is not None and not ends:
        return radius
    if radius is not None or len(ends) != 2:
        raise SceneError(f"{place}: allowed is radius, or base_radius and top_radius in its place; "
                         f"{'both are' if radius is not None else 'neither is'} stated")  # fmt: skip
    if not any(map(is_traced, ends)) and not np.array_equal(*ends):
        raise SceneError(
            f"{place}: base_radius = {listed(ends[0])} and top_radius = {listed(ends[1])}; allowed is one radius. "
            'For two, use type = "cone"'
        )
    return ends[0]
