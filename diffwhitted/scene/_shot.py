"""Shots: a picture that a camera took, under which lamps, and how it shows light."""

from collections.abc import Collection, Mapping
from math import isfinite
from typing import ClassVar, Literal, get_args

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import SceneError
from ..records import Row, nearest_name, read_rows

PixelFilter = Literal["box", "gaussian", "mitchell"]
TEXTS = (
    Row("camera", "text", 'Name of the camera that took it. Default: "main", or the only one.', default=None),
    Row("picture", "text", "Picture file, relative to the scene file; file.exr:LAYER for a layer or part.",
        default=None),
    Row("mask", "text", "Grey picture, 1 where a pixel counts. Default: the alpha of the picture.", default=None),
    Row("encoding", "text", 'Of the numbers in the file: "linear", "srgb", "rec709", "gamma:2.2". Default: what the '
        "file says.", default=None),
)  # fmt: skip
"""The keys of a shot that are text."""


class Shot(eqx.Module):
    """A picture of the scene, for a fit: picture = exposure * radiance + black_level, before any encoding.

    - `camera`: its name; None: "main", or the only one.
    - `picture`, `mask`: files; a picture that is handed over in Python has none.
    - `encoding`: of the numbers in the file; None: what the file says.
    - `exposure`: a factor, one number or linear RGB; `black_level`: what the darkest pixel shows.
    - `vignetting`, `gamma`, `response`: what lens and camera make of the light (see `shown`); None: nothing.
    - `lights`: the names of those that burn; None: all.
    - `noise`: a standard deviation; (read, gain) for variance = read^2 + gain * value; or a picture of standard
      deviations by its file name; None: found from what the fit leaves over.
    - `filter`: over which area a pixel averages, and how: "box" (the pixel), "gaussian" (standard deviation half a
      pixel, cut at 2 pixels), "mitchell" (Mitchell and Netravali 1988, B = C = 1/3); None: pixel or point,
      which is found out.

    Raises `SceneError` for a value that is not allowed.
    """

    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("exposure", "number or colour", "Factor of the light: the picture shows exposure * radiance + black_level. "
            "A factor, not stops.", default=1.0, lowest=0, excluded=True, scale="log", fit_bounds=(0.01, 100.0)),
        Row("black_level", "number or colour", "What a pixel without light shows, linear.", default=0.0,
            scale="unbounded", fit_bounds=(-0.5, 0.5)),
        Row("vignetting", "vector", "The light falls off to the corners: times 1 + v1 r^2 + v2 r^4 + v3 r^6, r = 1 in "
            "the corners.", default=None, scale="unbounded", parts=("v1", "v2", "v3"), fit_bounds=(-1.0, 1.0)),
        Row("gamma", "number", "Camera response: shows x^(1/gamma) of what it gets.", default=None, lowest=0,
            excluded=True, scale="log", fit_bounds=(0.2, 5.0)),
        Row("response", "vector", "Camera response: shows x + x (1 - x) (c1 + c2 x + c3 x^2) of what it gets.",
            default=None, scale="unbounded", parts=("c1", "c2", "c3"), fit_bounds=(-1.0, 1.0)),
    )  # fmt: skip

    exposure: Float[Array, "*channels"]
    black_level: Float[Array, "*channels"]
    vignetting: Float[Array, "3"] | None
    gamma: Float[Array, ""] | None
    response: Float[Array, "3"] | None
    name: str = eqx.field(static=True)
    camera: str | None = eqx.field(static=True)
    picture: str | None = eqx.field(static=True)
    mask: str | None = eqx.field(static=True)
    encoding: str | None = eqx.field(static=True)
    lights: tuple[str, ...] | None = eqx.field(static=True)
    noise: float | tuple[float, float] | str | None = eqx.field(static=True)
    filter: PixelFilter | None = eqx.field(static=True)

    def __init__(
        self,
        name: str,
        camera: str | None = None,
        picture: str | None = None,
        mask: str | None = None,
        encoding: str | None = None,
        exposure=1.0,
        black_level=0.0,
        lights: Collection[str] | None = None,
        noise=None,
        filter: PixelFilter | None = None,
        vignetting=None,
        gamma=None,
        response=None,
        place: str | None = None,
    ):
        place = place or f"shot {name!r}"
        read_rows(
            self,
            place,
            exposure=exposure,
            black_level=black_level,
            vignetting=vignetting,
            gamma=gamma,
            response=response,
        )
        self.name, self.camera, self.picture, self.mask, self.encoding = name, camera, picture, mask, encoding
        self.lights = None if lights is None else tuple(lights)
        self.noise, self.filter = _noise(noise, place), filter
        if "." in name:
            raise SceneError(f"{place}: allowed is a name without a dot, so that its numbers have names")
        if filter is not None and filter not in get_args(PixelFilter):
            raise SceneError(f"{place}: filter = {filter!r}; allowed is {', '.join(get_args(PixelFilter))}")

    def shown(
        self, radiance: Float[Array, "3 *n"], across: Float[Array, "*n"], down: Float[Array, "*n"]
    ) -> Float[Array, "3 *n"]:
        """What the picture shows of light: exposure * radiance * vignetting + black_level, then the camera's response.

        `across`, `down`: place in the picture from its middle, such that r^2 = across^2 + down^2 is 1 in the corners.
        A value <= 0 is shown as it is by a gamma, with derivative 0 in it.
        """

        def of_channel(factor):
            return factor[:, None] if factor.ndim else factor

        light = of_channel(self.exposure) * radiance
        if self.vignetting is not None:
            square = across**2 + down**2
            v1, v2, v3 = self.vignetting
            light = light * (1 + square * (v1 + square * (v2 + square * v3)))
        light = light + of_channel(self.black_level)
        if self.gamma is not None:
            lit = light > 0
            light = jnp.where(lit, jnp.where(lit, light, 1) ** (1 / self.gamma), light)
        if self.response is not None:
            c1, c2, c3 = self.response
            light = light + light * (1 - light) * (c1 + light * (c2 + light * c3))
        return light

    def burns(self, light: str | None) -> bool:
        """Does the light of that name burn in it?"""
        return self.lights is None or light in self.lights

    @property
    def is_plain(self) -> bool:
        """Does it show light times a factor and plus a level, and no more?"""
        return self.vignetting is None and self.gamma is None and self.response is None

    def check(self, cameras: Collection[str], lights: Collection[str]) -> None:
        """Raise `SceneError` unless the camera and the lights that it names are there."""
        named = [("camera", self.camera, cameras)] if self.camera is not None else []
        for kind, name, there in (*named, *(("light", name, lights) for name in self.lights or ())):
            if name not in there:
                listed = ", ".join(there) or "none at all"
                raise SceneError(
                    f"shot {self.name!r}: there is no {kind} {name!r}; there is {listed}.{nearest_name(name, there)}"
                )


def _noise(noise, place: str):
    """A standard deviation, (read, gain), or the name of a picture. Raises `SceneError` for anything else."""
    if noise is None or isinstance(noise, str):
        return noise
    allowed = "allowed is a standard deviation > 0, { read = ..., gain = ... } with both >= 0, or the file of a picture"
    if isinstance(noise, Mapping):
        if not noise or not set(noise) <= {"read", "gain"}:
            raise SceneError(f"{place}: noise = {dict(noise)}; {allowed}")
        noise = noise.get("read", 0.0), noise.get("gain", 0.0)
    numbers = noise if isinstance(noise, (tuple, list)) else (noise,)
    try:
        values = tuple(map(float, numbers))
    except (TypeError, ValueError):
        raise SceneError(f"{place}: noise = {noise!r}; {allowed}") from None
    if not 1 <= len(values) <= 2 or not all(isfinite(v) and v >= 0 for v in values) or not any(values):
        raise SceneError(f"{place}: noise = {noise!r}; {allowed}")
    return values if len(values) == 2 else values[0]


def from_middle(column, row, width: int, height: int):
    """How far places of a picture, in pixels from its top left corner, are across and down from its middle, in halves
    of its diagonal: as `Shot.shown` wants them.
    """
    half = 0.5 * (width**2 + height**2) ** 0.5
    return (column - width / 2) / half, (row - height / 2) / half
