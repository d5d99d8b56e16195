"""Pinhole cameras."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...geometry import Ray
from ...numerics._safe import length, normalise
from ...numerics._vector import Vec3, vec3
from ...records import Row, is_traced, read_rows
from ._camera import PRINCIPAL_POINT, VIEW, AbstractCamera
from ._distortion import DISTORTION, check_inverse, undistorted
from ._lens import LENS
from ._picture import Side


class Camera(AbstractCamera):
    """A pinhole at `look_from`. `vfov_deg` is the full vertical angle of view in degrees; `focal` = (fx, fy), in
    pixels, stands in place of it.

    The picture has `height` rows from the top and `width` columns from the left, square pixels without `focal`. Its
    middle, or `principal_point` = (cx, cy) in pixels from the top left corner, looks at `look_at`. `distortion` = (k1,
    k2, p1, p2) of OpenCV bends what a lens of glass bends. `crop` = (left, top, width, height): the picture is this
    window, in pixels of the full one; focal, principal point and angle of view stay those of the full one.
    `from_pose` takes a matrix in place of look_from, look_at and up. With `aperture` and `focus` it has a thin lens in
    place of the pinhole, and its `shutter` is open so many seconds, in which it moves with its `velocity` and the
    objects with theirs; over both `blur_samples` trees a pixel are averaged.

    Differentiable in all of its numbers. Raises `SceneError` for a degenerate camera: look_at at look_from, `up` along
    the line of sight, an aperture without a focus, both an angle and a focal length or neither, a crop outside the
    picture, or a distortion without an inverse in it.
    """

    TYPE: ClassVar[str] = "perspective"
    ROWS: ClassVar[tuple[Row, ...]] = (
        *VIEW,
        Row("vfov_deg", "number", "Full vertical angle of view, degrees; of the full picture.", unit="deg",
            default=None, lowest=0, highest=180, excluded=True, moves="rays"),
        Row("focal", "numbers", "Focal length across and down, pixels of the full picture, in place of vfov_deg.",
            unit="px", default=None, lowest=0, excluded=True, scale="log", moves="rays", parts=("x", "y")),
        PRINCIPAL_POINT,
        DISTORTION,
        *LENS,
    )  # fmt: skip

    look_from: Float[Array, "3"]
    look_at: Float[Array, "3"]
    up: Float[Array, "3"]
    vfov_deg: Float[Array, ""] | None
    focal: Float[Array, "2"] | None
    principal_point: Float[Array, "2"] | None
    distortion: Float[Array, "4"] | None
    width: int = eqx.field(static=True)
    height: int = eqx.field(static=True)
    full: tuple[Side, Side] = eqx.field(static=True)
    crop: tuple[Side, ...] | None = eqx.field(static=True)

    def __init__(
        self,
        look_from,
        look_at,
        vfov_deg=None,
        width: int = 0,
        height: int = 0,
        up=(0.0, 1.0, 0.0),
        *,
        focal=None,
        principal_point=None,
        distortion=None,
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
        if (vfov_deg is None) == (focal is None):
            fault = (
                "vfov_deg and focal are both stated" if focal is not None else "vfov_deg is missing, and so is focal"
            )
            raise SceneError(
                f"{place}: {fault}; allowed is one of the two: vfov_deg, the vertical angle of view in degrees, or "
                "focal = [fx, fy] in pixels"
            )
        read_rows(self, place, vfov_deg=vfov_deg, focal=focal, distortion=distortion)
        lens = (self.distortion, self.vfov_deg, self.focal, self.principal_point)
        if self.distortion is not None and not any(map(is_traced, lens)):
            check_inverse(self.distortion, self._flat, self.width, self.height, self.crop, place)

    def _flat(self, column, row):
        """Places of the full picture at z = 1, x to the right and y down, before the distortion is undone."""
        if self.focal is None:
            across, upwards = self.offset(column, row, _span(self.vfov_deg))
            return across, -upwards
        cx, cy = self.principal_point if self.principal_point is not None else (side / 2 for side in self.full)
        return (column - cx) / self.focal[0], (row - cy) / self.focal[1]

    def through(self, column: Float[Array, "*n"], row: Float[Array, "*n"]) -> Ray:
        """Rays through places of the full picture.

        direction = ahead + right (column/width - 1/2) 2 tan(vfov/2) width/height + up (1/2 - row/height) 2 tan(vfov/2)

        or ahead + right (column - cx)/fx - up (row - cy)/fy, with a distortion undone on these two numbers.
        """
        position, ahead, right, top = self.axes()
        if self.focal is None and self.distortion is None:
            across, upwards = self.offset(column, row, _span(self.vfov_deg))
        else:
            x, y = self._flat(column, row)
            across, down = (x, y) if self.distortion is None else undistorted(self.distortion, x, y)
            upwards = -down
        direction = normalise(ahead + right * across + top * upwards)
        return Ray(position * jnp.ones_like(direction.x), direction)

    def apart(self, origin: Vec3) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """In the middle of the picture, a distortion left out."""
        angle = _span(self.vfov_deg) / self.full[1] if self.focal is None else 1 / jnp.min(self.focal)
        return length(origin - vec3(self.look_from)) * angle, angle * jnp.ones_like(origin.x)

    def scaled(self, by: float) -> dict:
        return {} if self.focal is None else {"focal": self.focal * by}


def _span(vfov_deg) -> Float[Array, ""]:
    """Height of the full picture at z = 1."""
    return 2 * jnp.tan(jnp.deg2rad(vfov_deg) / 2)
