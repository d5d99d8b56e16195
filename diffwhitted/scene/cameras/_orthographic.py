"""Cameras of parallel rays."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...geometry import Ray
from ...numerics._vector import Vec3
from ...records import Row, read_rows
from ._camera import PRINCIPAL_POINT, VIEW, AbstractCamera
from ._lens import LENS
from ._picture import Side


class OrthographicCamera(AbstractCamera):
    """Parallel rays, from the plane through `look_from` across the view: what lies behind that plane is not seen.

    `view_height` is how much is seen from top to bottom, metres; the picture has `height` rows and `width` columns of
    square pixels, and its middle (or `principal_point` = (cx, cy), in pixels from the top left corner) looks at
    `look_at`. `crop` = (left, top, width, height): the picture is this window, in pixels of the full one, which is
    `view_height` high. `from_pose` takes a matrix in place of look_from, look_at and up. `aperture`, `focus`,
    `shutter`, `velocity` and `blur_samples` are those of `Camera`: each pixel has a lens of its own, square to its ray.

    Differentiable in all of its numbers. Raises `SceneError` for a degenerate camera: look_at at look_from, `up` along
    the line of sight, or a crop outside the picture.
    """

    TYPE: ClassVar[str] = "orthographic"
    ROWS: ClassVar[tuple[Row, ...]] = (
        *VIEW,
        Row("view_height", "number", "What is seen from top to bottom, metres; of the full picture.", unit="m",
            lowest=0, excluded=True, scale="log", moves="rays"),
        PRINCIPAL_POINT,
        *LENS,
    )  # fmt: skip

    look_from: Float[Array, "3"]
    look_at: Float[Array, "3"]
    up: Float[Array, "3"]
    view_height: Float[Array, ""]
    principal_point: Float[Array, "2"] | None
    width: int = eqx.field(static=True)
    height: int = eqx.field(static=True)
    full: tuple[Side, Side] = eqx.field(static=True)
    crop: tuple[Side, ...] | None = eqx.field(static=True)

    def __init__(
        self,
        look_from,
        look_at,
        view_height,
        width: int,
        height: int,
        up=(0.0, 1.0, 0.0),
        *,
        principal_point=None,
        crop=None,
        aperture=None,
        focus=None,
        shutter=None,
        velocity=None,
        blur_samples: int | None = None,
        place: str = "camera",
    ):
        lens = {"aperture": aperture, "focus": focus, "blur_samples": blur_samples}
        lens |= {"shutter": shutter, "velocity": velocity}
        self._stand(place, look_from, look_at, up, width, height, principal_point, crop, **lens)
        read_rows(self, place, view_height=view_height)

    def through(self, column: Float[Array, "*n"], row: Float[Array, "*n"]) -> Ray:
        """Rays through places of the full picture.

        origin = look_from + right (column/width - 1/2) view_height width/height + up (1/2 - row/height) view_height
        """
        position, ahead, right, top = self.axes()
        across, upwards = self.offset(column, row, self.view_height)
        origin = position + right * across + top * upwards
        return Ray(origin, ahead * jnp.ones_like(origin.x))

    def apart(self, origin: Vec3) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        one = jnp.ones_like(origin.x)
        return one * (self.view_height / self.full[1]), one * 0

    def starts(self) -> tuple[np.ndarray, float]:
        column, row = jnp.asarray([(x, y) for x in (0, self.width) for y in (0, self.height)], float).T
        origins = np.asarray(jax.tree.map(jnp.asarray, self).rays(column, row).origin.stacked(), np.float64)
        middle = origins.mean(axis=0)
        return middle, float(np.linalg.norm(origins - middle, axis=1).max()) + self.lens_radius()
