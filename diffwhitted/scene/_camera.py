"""The pinhole camera."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._errors import SceneError
from ..geometry import NOTHING, Footprint, Ray
from ..numerics._safe import normalise, rescaled
from ..numerics._vector import cross, vec3
from ..records import Row, is_traced, moved, read_rows

FAR = 300.0
"""A camera so many times further from the origin than from what it looks at is far away."""
LARGEST_SIDE = 32768
"""Pixels; a picture of this width and height still numbers its pixels in 32 bits."""


class Camera(eqx.Module):
    """A pinhole at `look_from`; `vfov_deg` is the full vertical angle of view in degrees.

    The picture has `height` rows from the top and `width` columns from the left, with square pixels.
    Raises `SceneError` for a degenerate camera: look_at at look_from, or `up` along the line of sight.
    """

    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("look_from", "vector", "Position of the pinhole, metres.", unit="m", scale="unbounded", moves="rays"),
        Row("look_at", "vector", "A point in the middle of the picture, metres.", unit="m", scale="unbounded",
            moves="rays", freedom="turn", about="look_from"),
        Row("up", "direction", "Direction that is up in the picture.", default=(0.0, 1.0, 0.0), scale="unbounded",
            moves="rays", freedom="roll", about="look_from look_at"),
        Row("vfov_deg", "number", "Full vertical angle of view, degrees.", unit="deg", lowest=0, highest=180,
            excluded=True, moves="rays"),
    )  # fmt: skip

    look_from: Float[Array, "3"]
    look_at: Float[Array, "3"]
    up: Float[Array, "3"]
    vfov_deg: Float[Array, ""]
    width: int = eqx.field(static=True)
    height: int = eqx.field(static=True)

    def __init__(
        self, look_from, look_at, vfov_deg, width: int, height: int, up=(0.0, 1.0, 0.0), place: str = "camera"
    ):
        read_rows(self, place, look_from=look_from, look_at=look_at, up=up, vfov_deg=vfov_deg)
        self.width, self.height = _size(width, place, "width"), _size(height, place, "height")
        if not any(map(is_traced, (self.look_from, self.look_at, self.up))):
            self._check_frame(place)

    def _check_frame(self, place: str):
        ahead = np.asarray(self.look_at, np.float64) - np.asarray(self.look_from, np.float64)
        up = np.asarray(self.up, np.float64)
        if not ahead.any():
            raise SceneError(f"{place}: look_at equals look_from, so it looks nowhere; move one of them")
        if np.linalg.norm(np.cross(ahead, up)) <= 1e-6 * np.linalg.norm(ahead) * np.linalg.norm(up):
            raise SceneError(
                f"{place}: up = {up.tolist()} lies along the line of sight (or is zero); "
                f"choose another, such as {np.eye(3, dtype=int)[_across(ahead)].tolist()}"
            )

    def resized(self, width: int | None = None, height: int | None = None) -> "Camera":
        """The same view at another size; one of the two alone keeps the shape of the picture."""
        if width is None and height is None:
            return self
        width, height = (
            side if side is None else _size(side, "camera", field)
            for side, field in ((width, "width"), (height, "height"))
        )
        if width is None:
            width = max(1, round((height or 1) * self.width / self.height))
        if height is None:
            height = max(1, round(width * self.height / self.width))
        return Camera(self.look_from, self.look_at, self.vfov_deg, width, height, self.up)

    def pixel_angle(self) -> Float[Array, ""]:
        """Distance of neighbouring pixels in the picture, one unit ahead; in the middle that is their angle in
        radians.
        """
        return 2 * jnp.tan(jnp.deg2rad(self.vfov_deg) / 2) / self.height

    @property
    def is_far(self) -> bool:
        """Is it known to be so far from the origin that float32 blurs what it sees?"""
        if is_traced(self.look_from) or is_traced(self.look_at):
            return False
        here, there = (np.asarray(place, np.float64) for place in (self.look_from, self.look_at))
        return float(abs(here).max()) > FAR * float(abs(there - here).max())

    def moved(self, by: np.ndarray) -> "Camera":
        """The same view from elsewhere, moved by so many metres, (3,)."""
        return moved(self, by)

    def in_precision(self, dtype) -> "Camera":
        """The same in the precision of a scene, which decides."""
        return jax.tree.map(lambda a: a.astype(dtype), self)

    def rays(self, column: Float[Array, "*n"], row: Float[Array, "*n"]) -> Ray:
        """Rays through picture positions; (0.5, 0.5) is the centre of the first pixel, top left.

        direction = ahead + right (column/width - 1/2) 2 tan(vfov/2) width/height + up (1/2 - row/height) 2 tan(vfov/2)
        """
        position = vec3(self.look_from)
        ahead = normalise(rescaled(vec3(self.look_at) - position)[0])
        right = normalise(cross(ahead, rescaled(vec3(self.up))[0]))
        top = cross(right, ahead)
        span = 2 * jnp.tan(jnp.deg2rad(self.vfov_deg) / 2)
        across = (column / self.width - 0.5) * span * (self.width / self.height)
        upwards = (0.5 - row / self.height) * span
        direction = normalise(ahead + right * across + top * upwards)
        return Ray(position * jnp.ones_like(direction.x), direction)

    def place(
        self, pixel: Int[Array, "*n"], inside: Float[Array, "2"]
    ) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """Column and row of the place `inside` pixels (0.5, 0.5 the centre), which are counted row by row."""
        dtype = self.look_from.dtype
        return (pixel % self.width).astype(dtype) + inside[0], (pixel // self.width).astype(dtype) + inside[1]

    def footprint(self, column: Float[Array, "*n"], row: Float[Array, "*n"], side: Float[Array, ""]) -> Footprint:
        """The change of the rays through these positions over squares of `side` times `side` pixels."""
        place, side, none = (column, row), side * jnp.ones_like(column), jnp.zeros_like(column)
        across, down = (jax.jvp(self.rays, place, way)[1] for way in ((side, none), (none, side)))
        return Footprint(across, down, jnp.full(column.shape, NOTHING, jnp.int32))


def _across(ahead: np.ndarray) -> int:
    """The axis that is least along a direction; of equals y, then z."""
    return min((1, 2, 0), key=lambda axis: abs(ahead[axis]))


def _size(value, place: str, field: str) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 1 <= value <= LARGEST_SIDE:
        raise SceneError(f"{place}: {field} = {value!r}; allowed is a whole number of pixels from 1 to {LARGEST_SIDE}")
    return int(value)
