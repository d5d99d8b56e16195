"""The scene: everything that is there, and how light is to be treated."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, get_args

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import FarFromOrigin, SceneError
from ..records import Row, changed, in_dtype, nearest_name, number_array, require, whole_number
from ..shapes import OBJECTS, AbstractObject, has_pose
from ._hemisphere import Ambient, Hemisphere
from ._interreflection import Interreflection
from ._material import Material
from ._notes import give_notes
from ._relief import check_relief
from ._shot import Shot
from .backgrounds import BACKGROUNDS, AbstractBackground, ConstantBackground
from .cameras import CAMERAS, AbstractCamera
from .lights import LIGHTS, AbstractLight
from .textures import TEXTURES, AbstractTexture

ShadowModel = Literal["opaque", "tinted", "off"]
TotalReflection = Literal["full", "whitted"]
Precision = Literal["float32", "float64"]

LARGEST_FOOTPRINT = 64
LARGEST_BANDS = 128
LARGEST_SEED = 2**31 - 1
DISTANCE_FADE = Row(
    "distance_fade", "numbers", "(a, b): light along a ray of d metres between two surfaces, or to the camera, is "
    "multiplied by max(0, a + b d); b in 1/m. Default: it is not.", default=None, scale="unbounded", parts=("a", "b"),
)  # fmt: skip


class Scene(eqx.Module):
    """An inert record of objects, materials, lights and cameras; a pytree of arrays.

    `precision` is the floating-point type of every array in it and so of the whole computation;
    "float64" needs `jax.config.update("jax_enable_x64", True)` first. `footprint` = k traces k x k trees a pixel
    whose rays know their share of it, so that edges are averaged over the pixel; 0 traces points. A branch
    that would carry less than `cutoff` in all channels is not followed; 0 follows every branch. `ambient` is linear
    RGB, or a `Hemisphere`. `distance_fade` = (a, b) multiplies the light along a ray of length d from a surface to
    another, or to the camera, by max(0, a + b d). `radiosity` = {"patches": 500, "solver":
    "progressive"} puts the light that diffuse surfaces send to each other in the place of ambient light.
    """

    objects: tuple[AbstractObject, ...]
    materials: dict[str, Material]
    lights: tuple[AbstractLight, ...]
    cameras: dict[str, AbstractCamera]
    textures: dict[str, AbstractTexture]
    background: AbstractBackground
    shots: tuple[Shot, ...]
    """Pictures of it that a fit looks at; rendering does not read them."""
    ambient: Ambient
    distance_fade: Float[Array, "2"] | None
    radiosity: Interreflection | None = eqx.field(static=True)
    """Light between diffuse surfaces in place of the ambient light; None: there is none."""
    cutoff: Float[Array, ""]
    max_depth: int = eqx.field(static=True)
    total_internal_reflection: TotalReflection = eqx.field(static=True)
    shadows: ShadowModel = eqx.field(static=True)
    footprint: int = eqx.field(static=True)
    bands: int = eqx.field(static=True)
    """Of the spectrum, each traced by itself, where a material disperses light: 3 are red, green and blue; 1: no
    dispersion."""
    seed: int = eqx.field(static=True)
    """Of what is left to chance (see `roughness`): another one draws other samples."""
    keeps_digits: bool = eqx.field(static=True)
    """It is far from the origin of its coordinates: objects, lights, cameras and textures hold the numbers as they were
    given, and are in the scene's precision relative to the camera that sees them (see `near`)."""

    def __init__(
        self,
        *,
        objects: Sequence[AbstractObject],
        materials: Mapping[str, Material],
        lights: Sequence[AbstractLight] = (),
        cameras: Mapping[str, AbstractCamera] | None = None,
        textures: Mapping[str, AbstractTexture] | None = None,
        background: AbstractBackground | None = None,
        shots: Sequence[Shot] = (),
        ambient=(1.0, 1.0, 1.0),
        max_depth: int = 5,
        total_internal_reflection: TotalReflection = "full",
        shadows: ShadowModel = "opaque",
        footprint: int = 0,
        bands: int = 3,
        seed: int = 0,
        cutoff: float = 0.0,
        precision: Precision = "float32",
        distance_fade=None,
        radiosity=None,
    ):
        dtype = float_dtype(precision)
        background = ConstantBackground((0.0, 0.0, 0.0)) if background is None else background
        _check_kinds(objects, lights, (textures or {}).values(), background, (cameras or {}).values())

        def cast(record):
            return in_dtype(record, dtype)

        far = [camera for camera in (cameras or {}).values() if camera.is_far] if dtype == np.float32 else []
        _warn_if_rounded(far)
        self.keeps_digits = bool(far)
        placed = (lambda record: record) if far else cast
        self.objects, self.lights = tuple(map(placed, objects)), _named(map(placed, lights))
        self.materials = {name: cast(material) for name, material in materials.items()}
        self.cameras, self.textures = (
            {name: placed(record) for name, record in (records or {}).items()} for records in (cameras, textures)
        )
        self.background, self.shots = cast(background), tuple(map(cast, shots))
        if not isinstance(ambient, Hemisphere):
            ambient = number_array(ambient, "scene", "ambient", ((), (3,))) * np.ones(3)
            require(lambda a: (a >= 0).all(), "scene", "ambient", ambient, ">= 0")
        self.ambient = cast(ambient)
        self.distance_fade = None if distance_fade is None else cast(_fade(distance_fade))
        self.radiosity = Interreflection.read(radiosity)
        self.cutoff = cast(_cutoff(cutoff))
        self.max_depth, self.shadows, self.footprint = max_depth, shadows, footprint
        self.bands, self.seed = _bands(bands), whole_number(seed, "scene: seed", 0, LARGEST_SEED)
        self.total_internal_reflection = total_internal_reflection
        self._check_settings()
        self._check_references()
        give_notes(self.placed_objects(), self.materials, self.lights, self.cameras, self.background)

    @property
    def dtype(self):
        return self.cutoff.dtype

    @property
    def precision(self) -> Precision:
        return "float64" if self.dtype == jnp.float64 else "float32"

    def placed_objects(self) -> tuple[AbstractObject, ...]:
        """The objects where their transforms have taken them."""
        return tuple(thing.as_placed() if has_pose(thing) else thing for thing in self.objects)

    def with_cutoff(self, cutoff: float | None) -> "Scene":
        """The scene with another cutoff; None leaves it as it is."""
        if cutoff is None:
            return self
        return eqx.tree_at(lambda s: s.cutoff, self, _cutoff(cutoff).astype(self.dtype))

    def _check_settings(self):
        if isinstance(self.max_depth, bool) or not isinstance(self.max_depth, int) or not 1 <= self.max_depth <= 64:
            raise SceneError(
                f"scene: max_depth = {self.max_depth!r}; allowed is a whole number from 1 (camera rays only) to 64"
            )
        check_footprint(self.footprint)
        for field, kind in (("shadows", ShadowModel), ("total_internal_reflection", TotalReflection)):
            if getattr(self, field) not in get_args(kind):
                raise SceneError(f"scene: {field} = {getattr(self, field)!r}; allowed is {', '.join(get_args(kind))}")

    def _check_references(self):
        _no_twins("light", [name for light in self.lights if (name := light.name)])
        for light in self.lights:
            if "." in (light.name or ""):
                raise SceneError(
                    f"light {light.name!r}: allowed is a name without a dot, so that its numbers have names"
                )
        _no_twins("shot", [shot.name for shot in self.shots])
        for shot in self.shots:
            if self.radiosity is not None and shot.lights is not None:
                raise SceneError(
                    f"shot {shot.name!r}: lights with radiosity, whose patches are lit by all lamps; leave one out"
                )
            shot.check(self.cameras, [light.name or "" for light in self.lights])
        seen = set()
        for thing in self.objects:
            if thing.name in seen:
                raise SceneError(f"object {thing.name!r}: two objects have this name; give each its own")
            seen.add(thing.name)
            _known(thing.material, self.materials, f"object {thing.name!r}: material")
        for name, material in self.materials.items():
            for key, texture in material.worn():
                _known(texture, self.textures, f"material {name!r}: {key}")
                self._check_uv(name, key, texture)
        check_relief(self.materials, self.textures, self.objects)

    def _check_uv(self, material: str, key: str, texture: str):
        """Raise `SceneError` where an object wears a texture that needs coordinates, and has none."""
        if not self.textures[texture].needs_uv:
            return
        for thing in self.objects:
            if thing.material == material and not thing.has_uv:
                raise SceneError(
                    f"object {thing.name!r} ({thing.written_type()}) has no texture coordinates, which texture "
                    f'{texture!r} ({key} of material {material!r}) with mapping = "uv" needs; write '
                    'mapping = "planar", "spherical", "cylindrical" or "triplanar" instead'
                )


def _named(lights: Iterable[AbstractLight]) -> tuple[AbstractLight, ...]:
    """The lights, those without a name called light_1, light_2, ... by their place."""
    return tuple(
        light if light.name else changed(light, name=f"light_{number}") for number, light in enumerate(lights, 1)
    )


def _warn_if_rounded(cameras: Iterable[AbstractCamera]) -> None:
    """Say of cameras far from the origin that were given in float32 that what they see was rounded before it came
    here.
    """
    for camera in cameras:
        if camera.look_from.dtype == np.float32:
            away = np.asarray(camera.look_from)
            warnings.warn(
                f"a camera at {away.tolist()} is far from the origin, where float32 resolves "
                f"{np.spacing(abs(away).max()):.2g} m, and its numbers were float32 when the scene was built; "
                "build the scene from Python's numbers or float64 arrays, or nearer to the origin",
                FarFromOrigin,
                stacklevel=4,
            )


def _check_kinds(objects, lights, textures, background, cameras) -> None:
    """Raise `SceneError` unless each of them is of a kind in its list."""
    of_kind = (
        (OBJECTS, objects),
        (LIGHTS, lights),
        (TEXTURES, textures),
        (BACKGROUNDS, (background,)),
        (CAMERAS, cameras),
    )
    for registry, things in of_kind:
        for thing in things:
            registry.check(thing, "scene")


def _no_twins(family: str, names: list[str]):
    for name in names:
        if names.count(name) > 1:
            raise SceneError(f"{family} {name!r}: two of them have this name; give each its own")


def _cutoff(value):
    cutoff = number_array(value, "scene", "cutoff", ((),))
    require(lambda a: 0 <= a < 1, "scene", "cutoff", cutoff, "0 (follow every branch) or more, below 1")
    return cutoff


def _bands(bands) -> int:
    if isinstance(bands, bool) or not isinstance(bands, int) or not (bands == 1 or 3 <= bands <= LARGEST_BANDS):
        raise SceneError(
            f"scene: bands = {bands!r}; allowed is 3 (red, green and blue) to {LARGEST_BANDS}, or 1 for no dispersion"
        )
    return bands


def _fade(value):
    fade = DISTANCE_FADE.read(value, "scene")
    some = "numbers a, b of which one is > 0, as a + b d is <= 0 at any distance d else, so no light would arrive"
    require(lambda ab: (ab > 0).any(), "scene", "distance_fade", fade, some)
    return fade


def check_footprint(footprint, place: str = "scene: "):
    """Raise `SceneError` unless it is a number of trees along the side of a pixel."""
    if isinstance(footprint, bool) or not isinstance(footprint, int) or not 0 <= footprint <= LARGEST_FOOTPRINT:
        raise SceneError(
            f"{place}footprint = {footprint!r}; allowed is 0 (points), 1 (one filtered tree a pixel) or k for "
            f"k x k of them, up to {LARGEST_FOOTPRINT}"
        )


def _known(name: str, there: Mapping, place: str):
    if name not in there:
        listed = ", ".join(map(repr, there)) or "none at all"
        raise SceneError(f"{place} = {name!r} is not in the scene; there is {listed}.{nearest_name(name, there)}")


def _has_float64() -> bool:
    return jax.config.jax_enable_x64  # pyright: ignore[reportAttributeAccessIssue]


def float_dtype(precision: str):
    """The floating-point type of a precision by name; `SceneError` where JAX is not set up for it."""
    if precision not in get_args(Precision):
        raise SceneError(f"precision = {precision!r}; allowed is {', '.join(get_args(Precision))}")
    if precision == "float64" and not _has_float64():
        raise SceneError('precision = "float64" needs 64-bit JAX: call jax.config.update("jax_enable_x64", True) first')
    return jnp.dtype(precision)
