"""A background of spherical harmonics."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...numerics._vector import Vec3
from ...records import Row, read_rows
from ._background import LIGHTS, AbstractBackground
from ._spherical_harmonics import degree_of, summed
from ._surroundings import Surroundings

COUNTS = (9, 16)


class HarmonicBackground(AbstractBackground):
    """A sum of real orthonormal spherical harmonics, one linear RGB coefficient for each: 9 up to degree 2, 16 up to
    degree 3.

    Their order is (l, m) = (0,0), (1,-1), (1,0), (1,1), (2,-2), ..., without the Condon-Shortley sign; polar axis +y,
    azimuth from -z towards +x. Radiance below 0 is not cut off.
    """

    TYPE: ClassVar[str] = "harmonics"
    KEYED: ClassVar[bool] = True
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("harmonics", "colours", "9 or 16 coefficients of real orthonormal spherical harmonics, linear RGB, in the "
            "order (0,0), (1,-1), (1,0), (1,1), (2,-2), ...; polar axis +y, azimuth from -z towards +x.",
            count=(COUNTS[0], COUNTS[-1]), scale="unbounded"),
        LIGHTS,
    )  # fmt: skip

    harmonics: Float[Array, "count 3"]
    lights: bool = eqx.field(static=True)

    def __init__(self, harmonics, lights: bool = True, place: str = "scene: background"):
        if np.ndim(harmonics) == 2 and len(harmonics) not in COUNTS:
            raise SceneError(
                f"{place}: harmonics has {len(harmonics)} entries; allowed is 9 (up to degree 2) or 16 (up to degree "
                "3) times [r, g, b]. Fill up with [0, 0, 0]"
            )
        read_rows(self, place, harmonics=harmonics, lights=lights)

    def seen(self, direction: Vec3) -> Vec3:
        return summed(jnp.asarray(self.harmonics), direction)

    def brightest(self) -> np.ndarray:
        """By the addition theorem: the squares of the harmonics of degree l are (2 l + 1) / (4 pi) in all.

        It bounds the size of what is negative too, and the mean weighted by any lobe, whose shares are at most 1.
        """
        held = np.asarray(self.harmonics, np.float64)
        total = np.abs(held[0]) * np.sqrt(1 / (4 * np.pi))
        for band in range(1, 1 + degree_of(len(held))):
            total = total + np.sqrt(
                (2 * band + 1) / (4 * np.pi) * np.square(held[band * band : (band + 1) ** 2]).sum(axis=0)
            )
        return total

    @property
    def lights_surfaces(self) -> bool:
        return self.lights

    def surroundings(self, shiny: np.ndarray) -> Surroundings | None:
        return Surroundings(jnp.asarray(self.harmonics), None, jnp.asarray(shiny)) if self.lights else None
