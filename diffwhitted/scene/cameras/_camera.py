"""The contract of a camera: where it stands, the picture that it takes, and the ray through each place of it."""

from abc import abstractmethod
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..._errors import SceneError
from ...geometry import NOTHING, Footprint, Ray
from ...numerics._safe import normalise, rescaled
from ...numerics._vector import Vec3, cross, vec3
from ...records import Row, changed, is_traced, moved, read_rows
from ._lens import LENS, check_lens, through_lens
from ._picture import Side, crop_of, pixels, whole
from ._pose import view_of

FAR = 300.0
"""A camera so many times further from the origin than from what it looks at is far away."""
VIEW: tuple[Row, ...] = (
    Row("look_from", "vector", "Position of the camera, metres.", unit="m", scale="unbounded", moves="rays"),
    Row("look_at", "vector", "A point straight ahead, metres.", unit="m", scale="unbounded",
        moves="rays", freedom="turn", about="look_from"),
    Row("up", "direction", "Direction that is up in the picture.", default=(0.0, 1.0, 0.0), scale="unbounded",
        moves="rays", freedom="roll", about="look_from look_at"),
)  # fmt: skip
"""The first rows of every camera."""
PRINCIPAL_POINT = Row(
    "principal_point", "numbers", "Column and row, in pixels of the full picture, where look_at is; (0, 0) is the top "
    "left corner of its top left pixel. Its middle unless stated.", unit="px", default=None, scale="unbounded",
    moves="rays", parts=("x", "y"),
)  # fmt: skip
LensPoint = tuple[Float[Array, "*n"], Float[Array, "*n"]]
"""Where rays leave the lens, to the right and upwards, in the unit disc."""


class AbstractCamera(eqx.Module):
    """A camera. A new kind states `TYPE`, `ROWS` (`VIEW`, `PRINCIPAL_POINT` and its own), `through`, `apart`, and these
    fields, which `_stand` reads; `__init__` takes the rows by their names, `width`, `height`, `crop`, and
    `place`, which is what messages call the record.

    The picture has `height` rows from the top and `width` columns from the left, with square pixels unless the kind
    says otherwise: the full one, or the window in it that `crop` says. A kind that states the rows of `LENS` too, and
    hands them to `_stand`, has a lens.
    """

    TYPE: ClassVar[str]
    """What scene files call it."""
    ALSO: ClassVar[dict[str, tuple[Row, ...]]] = {}
    ROWS: ClassVar[tuple[Row, ...]]

    look_from: eqx.AbstractVar[Float[Array, "3"]]
    look_at: eqx.AbstractVar[Float[Array, "3"]]
    up: eqx.AbstractVar[Float[Array, "3"]]
    principal_point: eqx.AbstractVar[Float[Array, "2"] | None]
    width: eqx.AbstractVar[int]
    """Of the picture that it takes; static, as are the next three."""
    height: eqx.AbstractVar[int]
    full: eqx.AbstractVar[tuple[Side, Side]]
    """Width and height of the full picture."""
    crop: eqx.AbstractVar[tuple[Side, ...] | None]
    """Left, top, width and height of the window in it; None where the picture is the full one."""
    aperture: Float[Array, ""] | None = eqx.field(default=None, kw_only=True)
    focus: Float[Array, ""] | None = eqx.field(default=None, kw_only=True)
    shutter: Float[Array, ""] | None = eqx.field(default=None, kw_only=True)
    velocity: Float[Array, "3"] | None = eqx.field(default=None, kw_only=True)
    blur_samples: int | None = eqx.field(default=None, kw_only=True, static=True)

    @abstractmethod
    def through(self, column: Float[Array, "*n"], row: Float[Array, "*n"]) -> Ray:
        """Rays through places of the full picture, (0, 0) its top left corner, of unit direction; differentiable."""

    @abstractmethod
    def apart(self, origin: Vec3) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """How far the rays of neighbouring pixels lie apart at a point, metres, and how much more for each metre
        further on.
        """

    def starts(self) -> tuple[np.ndarray, float]:
        """Middle (3,) and radius of a ball that holds the places where its rays begin, metres."""
        return np.asarray(self.look_from, np.float64), self.lens_radius()

    def lens_radius(self) -> float:
        """Metres; 0 without a lens."""
        return 0.0 if self.aperture is None else float(self.aperture) / 2

    def scaled(self, by: float) -> dict[str, Any]:
        """Those of its own numbers that are other ones in a picture `by` times as large."""
        return {}

    @classmethod
    def from_pose(cls, pose, convention: str = "opengl", *, place: str = "camera", **keys: Any):
        """The camera that stands where a matrix says.

        `pose`: (4, 4), camera to world, metres; its columns are the camera's axes in the world and its place.
        `convention`: of these axes, "opengl" (x right, y up, z backwards; Blender) or "opencv" (x right, y down, z
        ahead; COLMAP). `keys`: the other arguments of the class by name, such as `width`, `height` and `vfov_deg`.
        Raises `SceneError` for a rotation that is not orthonormal to 1e-4, or mirrors.
        """
        look_from, look_at, up = view_of(pose, convention, place, FAR)
        return cls(look_from=look_from, look_at=look_at, up=up, place=place, **keys)  # pyright: ignore[reportCallIssue]

    @classmethod
    def from_keys(cls, place: str = "camera", pose=None, convention: str | None = None, **keys: Any):
        """The camera that a table of a scene file stands for: its place by `pose`, or by look_from and look_at."""
        stated = [name for name in ("look_from", "look_at", "up") if name in keys]
        if pose is not None and stated:
            raise SceneError(
                f"{place}: pose says where it stands, and so does {', '.join(stated)}; write one of the two"
            )
        if pose is not None:
            return cls.from_pose(pose, convention or "opengl", place=place, **keys)
        if convention is not None:
            raise SceneError(f"{place}: convention = {convention!r} is that of a pose, and there is none; write one")
        for row in VIEW[:2]:
            if row.name not in keys:
                raise SceneError(
                    f"{place}: {row.name} is missing; allowed is a list of 3 numbers ({row.meaning.rstrip('.')}), or a "
                    "pose in place of look_from, look_at and up"
                )
        return cls(place=place, **keys)  # pyright: ignore[reportCallIssue]

    def keys(self) -> dict[str, Any]:
        """What `width`, `height` and `crop` were when it was made."""
        return {"width": self.full[0], "height": self.full[1], "crop": self.crop and list(self.crop)}

    def _stand(self, place: str, look_from, look_at, up, width, height, principal_point, crop, **lens) -> None:
        """Read what all cameras have, and what a lens has."""
        # Every field is set: equinox counts them to tell a record from a wrapped function.
        for row in LENS:
            setattr(self, row.name, None)
        read_rows(self, place, look_from=look_from, look_at=look_at, up=up, principal_point=principal_point, **lens)
        check_lens(self.aperture, self.focus, place)
        self.full = pixels(width, place, "width"), pixels(height, place, "height")
        self.crop = crop_of(crop, self.full, place)
        self.width, self.height = self.full if self.crop is None else self.crop[2:]
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

    def resized(self, width: int | None = None, height: int | None = None):
        """The same view at another size; one of the two alone keeps the shape of the picture.

        Of a picture of another shape the rows stay what they are, and the columns are more or fewer on both sides.
        """
        if width is None and height is None:
            return self
        width, height = (
            side if side is None else pixels(side, "camera", field)
            for side, field in ((width, "width"), (height, "height"))
        )
        if width is None:
            width = max(1, round((height or 1) * self.width / self.height))
        if height is None:
            height = max(1, round(width * self.height / self.width))
        by = height / self.height
        new: dict[str, Any] = {"width": width, "height": height, **self.scaled(by)}
        if self.crop is None:
            new["full"], aside = (width, height), width / 2 - by * self.width / 2
        else:
            left, top = (self.crop[0] + self.width / 2) * by - width / 2, self.crop[1] * by
            new["crop"], aside = (whole(left), whole(top), width, height), 0.0
            new["full"] = whole(self.full[0] * by), whole(self.full[1] * by)
        if self.principal_point is not None:
            new["principal_point"] = self.principal_point * by + np.asarray([aside, 0.0], self.principal_point.dtype)
        return changed(self, **new)

    @property
    def is_far(self) -> bool:
        """Is it known to be so far from the origin that float32 blurs what it sees?"""
        if is_traced(self.look_from) or is_traced(self.look_at):
            return False
        here, there = (np.asarray(place, np.float64) for place in (self.look_from, self.look_at))
        return float(abs(here).max()) > FAR * float(abs(there - here).max())

    def moved(self, by: np.ndarray):
        """The same view from elsewhere, moved by so many metres, (3,)."""
        return moved(self, by)

    def after(self, seconds: Float[Array, ""]):
        """The camera where its velocity takes it in so many seconds; differentiable."""
        if self.velocity is None:
            return self
        shift = self.velocity * seconds
        return changed(self, look_from=self.look_from + shift, look_at=self.look_at + shift)

    def in_precision(self, dtype):
        """The same in the precision of a scene, which decides."""
        return jax.tree.map(lambda a: a.astype(dtype), self)

    def written_type(self) -> str:
        return self.TYPE

    def axes(self) -> tuple[Vec3, Vec3, Vec3, Vec3]:
        """Where it stands, and unit vectors ahead, to the right and to the top of the picture."""
        position = vec3(self.look_from)
        ahead = normalise(rescaled(vec3(self.look_at) - position)[0])
        right = normalise(cross(ahead, rescaled(vec3(self.up))[0]))
        return position, ahead, right, cross(right, ahead)

    def offset(self, column: Float[Array, "*n"], row: Float[Array, "*n"], span: Float[Array, ""]):
        """How far places of the full picture lie to the right of what is straight ahead and above it, where the whole
        picture is `span` high.
        """
        width, height = self.full
        if self.principal_point is None:
            return (column / width - 0.5) * span * (width / height), (0.5 - row / height) * span
        pixel = span / height
        return (column - self.principal_point[0]) * pixel, (self.principal_point[1] - row) * pixel

    def rays(self, column: Float[Array, "*n"], row: Float[Array, "*n"], lens: LensPoint | None = None) -> Ray:
        """Rays through picture positions; (0.5, 0.5) is the centre of the first pixel, top left. Those of a crop are
        rays of the full picture. `lens`: where in it they leave the lens; without it, they go through its middle.
        """
        if self.crop is not None:
            column, row = column + self.crop[0], row + self.crop[1]
        ray = self.through(column, row)
        if lens is None or self.aperture is None or self.focus is None:
            return ray
        return through_lens(ray, self.axes()[1:], self.aperture, self.focus, lens)

    def place(
        self, pixel: Int[Array, "*n"], inside: Float[Array, "2"]
    ) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
        """Column and row of the place `inside` pixels (0.5, 0.5 the centre), which are counted row by row."""
        dtype = self.look_from.dtype
        return (pixel % self.width).astype(dtype) + inside[0], (pixel // self.width).astype(dtype) + inside[1]

    def footprint(
        self, column: Float[Array, "*n"], row: Float[Array, "*n"], side: Float[Array, ""], lens: LensPoint | None = None
    ) -> Footprint:
        """The change of the rays through these positions over squares of `side` times `side` pixels."""
        place, side, none = (column, row), side * jnp.ones_like(column), jnp.zeros_like(column)

        def rays(column, row):
            return self.rays(column, row, lens)

        across, down = (jax.jvp(rays, place, way)[1] for way in ((side, none), (none, side)))
        return Footprint(across, down, jnp.full(column.shape, NOTHING, jnp.int32))


def _across(ahead: np.ndarray) -> int:
    """The axis that is least along a direction; of equals y, then z."""
    return min((1, 2, 0), key=lambda axis: abs(ahead[axis]))
