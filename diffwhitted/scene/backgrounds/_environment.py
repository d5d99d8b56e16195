"""A map of all that is far away."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..._errors import SceneError
from ...numerics._stage import packed
from ...numerics._vector import Vec3, dot, vec3
from ...records import Row, is_traced, read_rows, rows_of
from ..textures._image import checked_texels
from ._background import LIGHTS, AbstractBackground
from ._lobes import OVERSHOOT, Lobes, rungs_of
from ._map_levels import MapLevels, halved, joined, place_on_map
from ._once import once
from ._projection import projected, turned
from ._surroundings import Surroundings

LEAST_SPREAD = 0.2
"""Texels; over a smaller footprint a bilinear map hardly bends."""
ASPECT = 0.01
"""By so much of its width a map may miss being twice as wide as high."""
PROBES = 4
"""Along each side of a footprint."""


class EnvironmentBackground(AbstractBackground):
    """An equirectangular map, bilinear, that lights surfaces too: Blinn and Newell 1976.

    The middle column looks along -z, the top row to +y, columns to the right turn towards +x. In Python it is built of
    `texels`, linear RGB of shape (height, width, 3), row 0 on top: `read_image(FILE).pixels` for instance. With an
    `environment` besides, that is the file as a scene file names it.
    """

    TYPE: ClassVar[str] = "environment"
    KEYED: ClassVar[bool] = True
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("environment", "text", "Picture file of an equirectangular map, twice as wide as high, relative to the "
            "scene file; file.exr:LAYER for a layer or part. Its middle looks along -z, its right towards +x."),
        Row("texels", "texels", "Its texels, linear RGB, row 0 on top.", lowest=0, default=None),
        Row("encoding", "text", 'Of the numbers in the file: "linear", "srgb", "rec709", "gamma:2.2". Default: what '
            "the file says.", default=None),
        Row("rotation_deg", "number", "The map is turned by it from -z to +x, degrees.", unit="degree", default=0.0,
            scale="unbounded", moves="patterns"),
        Row("scale", "number", "Multiplies the map.", default=1.0, lowest=0),
        LIGHTS,
    )  # fmt: skip

    texels: Float[Array | np.ndarray, "height width 3"]
    rotation_deg: Float[Array, ""]
    scale: Float[Array, ""]
    environment: str | None = eqx.field(static=True)
    encoding: str | None = eqx.field(static=True)
    lights: bool = eqx.field(static=True)

    def __init__(
        self,
        texels,
        *,
        rotation_deg=0.0,
        scale=1.0,
        lights: bool = True,
        environment: str | None = None,
        encoding: str | None = None,
        place: str = "scene: background",
    ):
        self.environment, self.encoding = environment, encoding
        self.texels = _checked(texels, place if environment is None else f"{place}: environment = {environment!r}")
        read_rows(self, place, rotation_deg=rotation_deg, scale=scale, lights=lights)

    def seen(self, direction: Vec3) -> Vec3:
        return self.tabled().seen(direction)

    def tabled(self) -> "EnvironmentTable":
        content = once(_levels, self.texels)
        levels = MapLevels(vec3(jnp.asarray(content[0])), content[1])
        return EnvironmentTable(levels, jnp.asarray(self.scale), jnp.asarray(self.rotation_deg))

    def brightest(self) -> np.ndarray:
        """The largest texel in each channel, (3,)."""
        return np.asarray(self.texels, np.float64).max(axis=(0, 1)) * float(self.scale)

    def brightest_mean(self) -> np.ndarray:
        return OVERSHOOT * self.brightest()

    @property
    def lights_surfaces(self) -> bool:
        return self.lights

    def surroundings(self, shiny: Bool[Array | np.ndarray, "materials"]) -> Surroundings | None:
        if not self.lights:
            return None
        coefficients = turned(jnp.asarray(once(projected, self.texels)), jnp.asarray(self.rotation_deg))
        lobes = None
        if is_traced(shiny) or np.any(shiny):
            texels, sizes = once(rungs_of, self.texels)
            rungs = MapLevels(vec3(jnp.asarray(texels)), sizes)
            lobes = Lobes(rungs, jnp.asarray(self.scale), jnp.asarray(self.rotation_deg))
        return Surroundings(coefficients * self.scale, lobes, jnp.asarray(shiny))


class EnvironmentTable(AbstractBackground):
    """A map on all its levels, for the ray tree."""

    TYPE: ClassVar[str] = EnvironmentBackground.TYPE
    ROWS: ClassVar[tuple[Row, ...]] = EnvironmentBackground.ROWS

    levels: MapLevels
    scale: Float[Array, ""]
    rotation_deg: Float[Array, ""]

    def seen(self, direction: Vec3) -> Vec3:
        return self._at(direction, 0)

    def mean(self, direction: Vec3, steps: tuple[Vec3, Vec3], wanted: Bool[Array, "n"]) -> Vec3:
        """By 4 x 4 probes, each on the level whose texels are as large as the probes are apart.

        Which level it is has no derivative.
        """
        rows, columns = self.levels.sizes[0]
        texel = max(np.pi / rows, 2 * np.pi / columns)
        spread = jax.lax.stop_gradient(jnp.maximum(*(dot(step, step) for step in steps)))
        wide = wanted & (spread > (LEAST_SPREAD * texel) ** 2)

        def probed(direction, steps, spread):
            apart = jnp.clip(spread / (PROBES * texel) ** 2, 1, 4.0 ** len(self.levels.sizes))
            level = jnp.clip(jnp.round(0.5 * jnp.log2(apart)), 0, len(self.levels.sizes) - 1).astype(jnp.int32)
            places = (np.arange(PROBES) + 0.5) / PROBES - 0.5

            def strip(total, s):
                for t in places.tolist():
                    total = total + self._at(direction + steps[0] * s + steps[1] * t, level)
                return total, None

            none = Vec3(*(jnp.zeros_like(direction.x) for _ in range(3)))
            total, _ = jax.lax.scan(strip, none, jnp.asarray(places, direction.dtype))
            return total * (1 / PROBES**2)

        return packed(wide, probed, self.seen(direction), direction, steps, spread)

    def _at(self, direction: Vec3, level) -> Vec3:
        return self.levels.at(*place_on_map(direction, self.rotation_deg), level) * self.scale


def _levels(texels):
    return joined(halved(texels))


def _checked(texels, place: str):
    """Texels as an array of floats, or `SceneError` naming the shape or the first one that is not allowed."""
    array = checked_texels(texels, place, rows_of(EnvironmentBackground)["texels"])
    height, width, _ = array.shape
    if abs(width - 2 * height) > max(1, ASPECT * width):
        raise SceneError(
            f"{place}: the map is {width} x {height} texels; allowed is twice as wide as high, such as "
            f"{2 * height} x {height}: the whole sphere, equirectangular. Resample it"
        )
    return array
