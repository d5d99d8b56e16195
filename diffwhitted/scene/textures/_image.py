"""Pictures on surfaces."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..._errors import SceneError
from ...numerics._safe import safe_divide, safe_sqrt
from ...numerics._vector import Vec3
from ...records import Row, changed, is_traced, listed, members_at, read_rows, require, rows_of, shifted
from ._levels import WRAPS, Levels, Wrap, pyramid
from ._mappings import MAPPINGS, blend
from ._texture import AbstractTexture, TexturePoint

LEAST_SPREAD = 0.2
"""Texels; over a smaller footprint a bilinear texture hardly bends."""
STRAIGHT = 0.05
"""Slant up to which a pixel is taken without perspective."""
SQUARE, OBLIQUE = (4, 4), (2, 16)
"""Probes along the shorter and the longer side of a footprint: up to 2 times as long as wide, and of all others."""


class ImageTexture(AbstractTexture):
    """A picture, bilinearly interpolated, that multiplies a coefficient.

    In Python it is built of `texels`, linear RGB of shape (height, width, 3), row 0 on top: `read_image(FILE).pixels`
    for instance. With a `file` besides, that is the name by which a scene file has it.
    """

    TYPE: ClassVar[str] = "image"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("file", "text", "Picture file, relative to the scene file; file.exr:LAYER for a layer or part."),
        Row("texels", "texels", "Its texels, linear RGB, row 0 on top.", lowest=0, default=None),
        Row("encoding", "text", 'Of the numbers in the file: "linear", "srgb", "rec709", "gamma:2.2". Default: what '
            "the file says.", default=None),
        Row("wrap", "choice", "What lies beside the picture: itself again, its edge, or its mirror image.",
            default="repeat", choices=WRAPS),
        Row("mapping", "choice", "How it lies on the surface: by the coordinates of the object, or by the place of the "
            "point.", default="uv", choices=tuple(MAPPINGS)),
        Row("origin", "vector", "planar: the lower left corner. Default: 0.", unit="m", default=None,
            scale="unbounded", moves="patterns"),
        Row("edge_u", "vector", "planar: from there to the lower right corner. Default: +x.", unit="m", default=None,
            nonzero=True, scale="unbounded", moves="patterns"),
        Row("edge_v", "vector", "planar: to the upper left corner. Default: +y.", unit="m", default=None, nonzero=True,
            scale="unbounded", moves="patterns"),
        Row("centre", "vector", "spherical, cylindrical: the middle; the axis is +y, the left edge faces -z. Default: "
            "0.", unit="m", default=None, scale="unbounded", moves="patterns"),
        Row("height", "number", "cylindrical: of the picture, half of it above the centre. Default: 1.", unit="m",
            default=None, lowest=0, excluded=True, scale="log", moves="patterns"),
        Row("size", "number", "triplanar: edge of the picture. Default: 1.", unit="m", default=None, lowest=0,
            excluded=True, scale="log", moves="patterns"),
    )  # fmt: skip
    FOOTPRINT: ClassVar[bool] = True
    SLOPED: ClassVar[bool] = True

    texels: Float[Array, "height width 3"]
    origin: Float[Array, "3"] | None
    edge_u: Float[Array, "3"] | None
    edge_v: Float[Array, "3"] | None
    centre: Float[Array, "3"] | None
    height: Float[Array, ""] | None
    size: Float[Array, ""] | None
    corner: Float[Array | np.ndarray, "3"]
    """triplanar: where the pictures have their corner; the origin, unless the texture was moved."""
    file: str | None = eqx.field(static=True)
    encoding: str | None = eqx.field(static=True)
    wrap: Wrap = eqx.field(static=True)
    mapping: str = eqx.field(static=True)

    def __init__(
        self,
        texels,
        *,
        mapping: str = "uv",
        wrap: Wrap = "repeat",
        origin=None,
        edge_u=None,
        edge_v=None,
        centre=None,
        height=None,
        size=None,
        file: str | None = None,
        encoding: str | None = None,
        place: str = "texture",
    ):
        for name, value, allowed in (("wrap", wrap, WRAPS), ("mapping", mapping, tuple(MAPPINGS))):
            if value not in allowed:
                raise SceneError(f"{place}: {name} = {value!r}; allowed is {', '.join(allowed)}")
        self.file, self.encoding, self.wrap, self.mapping = file, encoding, wrap, mapping
        self.texels = checked_texels(
            texels, place if file is None else f"{place}: file {file!r}", rows_of(ImageTexture)["texels"]
        )
        # Take the keys of the mapping, and no others.
        stated = dict(origin=origin, edge_u=edge_u, edge_v=edge_v, centre=centre, height=height, size=size)
        mine = MAPPINGS[mapping][1]
        for name in (name for name, value in stated.items() if value is not None and name not in mine):
            users = ", ".join(repr(other) for other, (_, keys) in MAPPINGS.items() if name in keys)
            raise SceneError(
                f"{place}: {name} is a key of mapping = {users}, and this texture has mapping = {mapping!r}; "
                f"allowed is {', '.join(mine) or 'none of its kind'}"
            )
        read_rows(self, place, **{n: mine[n] if v is None and n in mine else v for n, v in stated.items()})
        self._check_edges(place)
        self.corner = np.zeros(3)

    @property
    def needs_uv(self) -> bool:
        return self.mapping == "uv"

    def _check_edges(self, place: str) -> None:
        """Raise `SceneError` for two edges in one line."""
        if self.edge_u is None or self.edge_v is None or is_traced(self.edge_u) or is_traced(self.edge_v):
            return
        across, up = (np.asarray(e, np.float64) / np.abs(e).max() for e in (self.edge_u, self.edge_v))
        apart = np.linalg.norm(np.cross(across, up)) / (np.linalg.norm(across) * np.linalg.norm(up))
        allowed = f"any direction but that of edge_u = {listed(self.edge_u)}"
        require(lambda _: apart > 1e-6, place, "edge_v", self.edge_v, allowed)

    def at(self, point: TexturePoint) -> Vec3:
        table = self.tabled()
        alone = jax.tree.map(lambda a: jnp.asarray(a)[None], table)
        return alone.chosen(jnp.zeros(point.position.shape, jnp.int32)).at(point)

    def tabled(self) -> "ImageTable":
        keys = {name: getattr(self, name) for name in MAPPINGS[self.mapping][1]}
        if self.mapping == "triplanar":
            keys["corner"] = self.corner
        height, width, _ = self.texels.shape
        return ImageTable(pyramid(self.texels), keys, None, (height, width), self.wrap, self.mapping)

    def moved(self, by: np.ndarray) -> "ImageTexture":
        """The same, moved by so many metres; of a triplanar one that repeats less its whole periods."""
        places = {n: shifted(getattr(self, n), by) for n in ("origin", "centre") if getattr(self, n) is not None}
        corner = shifted(self.corner, by)
        if self.size is not None and self.wrap != "clamp":
            period = 2 * (self.size if is_traced(self.size) else np.asarray(self.size, np.float64))
            corner = corner % period
        return changed(self, corner=corner, **places)

    def brightest(self) -> np.ndarray:
        """The largest texel in each channel, (3,)."""
        return np.asarray(self.texels, np.float64).max(axis=(0, 1))


class ImageTable(AbstractTexture):
    """A picture on all its levels, for the ray tree: alone, or stacked with others of its size."""

    TYPE: ClassVar[str] = ImageTexture.TYPE
    ROWS: ClassVar[tuple[Row, ...]] = ImageTexture.ROWS
    FOOTPRINT: ClassVar[bool] = True
    SLOPED: ClassVar[bool] = True

    texels: Float[Array | np.ndarray, "..."]
    keys: dict[str, Float[Array, "..."]]
    """The numbers of the mapping."""
    which: Int[Array, "*n"] | None
    """The picture that each ray needs."""
    size_in_texels: tuple[int, int] = eqx.field(static=True)
    wrap: Wrap = eqx.field(static=True)
    mapping: str = eqx.field(static=True)

    def chosen(self, which: Int[Array, "n"]) -> "ImageTable":
        return changed(self, keys=members_at(self.keys, which), which=which)

    def at(self, point: TexturePoint) -> Vec3:
        return self._blended(point, lambda levels, uv: levels.at(*uv(point)))

    def mean(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint]) -> Vec3:
        return self._blended(point, lambda levels, uv: levels.mean(*_moving(uv, point, steps), None, SQUARE))

    def mean_in_perspective(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint], slant) -> Vec3:
        return self._blended(point, lambda levels, uv: levels.mean(*_moving(uv, point, steps), slant, OBLIQUE))

    def varies(self, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint], slant):
        slanted = 0.5 * (abs(slant[0]) + abs(slant[1]))
        wide, square = jnp.zeros(point.position.shape, bool), slanted < STRAIGHT
        for uv in self._coordinates():
            across, down = self._levels().spread(_moving(uv, point, steps)[1])
            longer, shorter = jnp.maximum(across, down), jnp.minimum(across, down)
            wide = wide | (longer > LEAST_SPREAD * jnp.maximum(1 - slanted, 0.1))
            square = square & ((longer < 2 * shorter) | (longer < 1))
        return wide & square, wide & ~square

    def slopes(self, point: TexturePoint, width, along: tuple[TexturePoint, ...]):
        def rises(levels: Levels, uv):
            (u, v), turns = self._turning(uv, point, along)
            in_u, in_v = levels.slopes(u, v, self._spread(turns, width))
            return tuple(in_u * du + in_v * dv for du, dv in turns)

        return self._blended(point, rises)

    def leanings(self, point: TexturePoint, width, along: tuple[TexturePoint, TexturePoint]):
        """The slopes of the surface whose normals are the texels: 2 c - 1 = (x, y, z) along +u, +v and outwards.

        `along`: two unit steps at right angles, right-handed with the outward normal. Edge: where u or v does not
        change, as at a pole, the slopes are 0.
        """

        def leans(levels: Levels, uv):
            (u, v), turns = self._turning(uv, point, along)
            colour = levels.softened(u, v, self._spread(turns, width))
            x, y = (safe_divide(1 - 2 * channel, 2 * colour.z - 1) for channel in (colour.x, colour.y))
            (u_one, u_other), (v_one, v_other) = zip(*turns, strict=True)
            side = jnp.sign(u_one * v_other - u_other * v_one)
            # The step in which u grows and v does not.
            size = safe_sqrt(v_one * v_one + v_other * v_other)
            one, other = safe_divide(side * v_other, size), safe_divide(-side * v_one, size)
            return x * one - y * side * other, x * other + y * side * one

        return self._blended(point, leans)

    def _turning(self, uv, point: TexturePoint, along: tuple[TexturePoint, ...]):
        """The coordinates, and their change along each of some steps; a blend of three mappings counts as fixed."""
        return uv(point), [jax.jvp(uv, (point,), (step,))[1] for step in along]

    def _spread(self, turns, width):
        """Texels over which a width is spread."""
        height, across = self.size_in_texels
        square = sum(((du * across) ** 2 + (dv * height) ** 2 for du, dv in turns), jnp.zeros_like(width))
        return width * safe_sqrt(0.5 * square)

    def _blended(self, point: TexturePoint, of_mapping):
        """What `of_mapping(levels, coordinates)` gives, Vec3 or other arrays, for the mapping, or for the three of
        them, weighted.
        """
        levels = self._levels()
        parts = [of_mapping(levels, uv) for uv in self._coordinates()]
        if len(parts) == 1:
            return parts[0]
        weights = blend(point.normal)
        return jax.tree.map(lambda *three: sum(a * w for a, w in zip(three, weights, strict=True)), *parts)

    def _coordinates(self):
        return MAPPINGS[self.mapping][0](self.keys)

    def _levels(self) -> Levels:
        assert self.which is not None, "chosen says which picture each ray needs"
        return Levels(jnp.asarray(self.texels), self.which, self.size_in_texels, self.wrap)


def _moving(uv, point: TexturePoint, steps: tuple[TexturePoint, TexturePoint]):
    """The coordinates, and their change along the sides of the pixel, to first order."""
    return uv(point), tuple(jax.jvp(uv, (point,), (step,))[1] for step in steps)


def checked_texels(texels, place: str, row: Row):
    """Texels as an array of floats, or `SceneError` naming the first one that is not allowed."""
    if is_traced(texels):
        return row.read(texels, place)
    try:
        array = np.asarray(texels)
        array = array if array.dtype in (np.float32, np.float64) else array.astype(np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"{place}: texels are no numbers; allowed is an array of shape (height, width, 3)") from None
    if array.ndim == 3 and array.size:
        bad = ~(np.isfinite(array) & (array >= 0)).all(axis=2)
        if bad.any():
            where = tuple(int(k) for k in np.argwhere(bad)[0])
            raise SceneError(
                f"{place}: the texel in row {where[0]}, column {where[1]} (from 0, top left) is "
                f"{array[where].tolist()}, and {int(bad.sum())} of {bad.size} texels are not finite or below 0; "
                "allowed is >= 0 in every channel. Repair the picture"
            )
    return row.read(array, place)
