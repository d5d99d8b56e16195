"""A shape, a light, a texture, a background, a camera, a coefficient and an effect that the package does not have.

Each is one class or one row, as a person would write it on the first day: without a footprint.
"""

from contextlib import ExitStack, contextmanager
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

import diffwhitted as dw
from diffwhitted.geometry import AbstractSurfaces, Ray
from diffwhitted.numerics._safe import length, normalise, safe_divide
from diffwhitted.numerics._vector import Vec3, dot, vec3
from diffwhitted.records import Row, read_rows
from diffwhitted.scene import (
    BACKGROUNDS,
    CAMERAS,
    LIGHTS,
    OBJECTS,
    TEXTURES,
    AbstractBackground,
    AbstractCamera,
    AbstractLight,
    AbstractTexture,
    including_coefficient,
)
from diffwhitted.scene.cameras import PRINCIPAL_POINT, VIEW
from diffwhitted.shapes import AbstractObject
from diffwhitted.tree import Effect, including_effect


class Coins(AbstractSurfaces):
    """Flat discs, of one side."""

    centre: Vec3
    normal: Vec3
    radius: Float[Array, "*n"]

    def crossings(self, ray, on_it, inwards):
        distance, _ = self._plane(ray)
        away = ray.at(distance) - self.centre
        met = (distance > 0) & ~on_it & (dot(away, away) < self.radius * self.radius)
        return (jnp.where(met, distance, jnp.inf),)

    def surface(self, ray, crossing):
        distance, entering = self._plane(ray)
        return distance, self.normal, ray.at(distance), entering

    def _plane(self, ray):
        towards = dot(self.normal, ray.direction)
        return safe_divide(dot(self.normal, self.centre - ray.origin), towards), towards < 0


class Coin(AbstractObject):
    """A flat disc."""

    TYPE: ClassVar[str] = "coin"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("centre", "vector", "Centre, metres.", unit="m", scale="unbounded", moves="rays"),
        Row("normal", "direction", "Of its upper side.", nonzero=True, scale="unbounded", moves="rays"),
        Row("radius", "number", "Metres.", unit="m", lowest=0, excluded=True, scale="log", moves="rays"),
    )
    FAMILY: ClassVar[type[AbstractSurfaces]] = Coins

    centre: Float[Array, "3"]
    normal: Float[Array, "3"]
    radius: Float[Array, ""]
    name: str = eqx.field(static=True)
    material: str = eqx.field(static=True)

    def __init__(self, name, centre, normal, radius, material, place=None):
        self.name, self.material = name, material
        read_rows(self, place or f"object {name!r}", centre=centre, normal=normal, radius=radius)

    @classmethod
    def family(cls, centre, normal, radius):
        return Coins(vec3(centre), normalise(vec3(normal)), radius)


class Beacon(AbstractLight):
    """A lamp that shines more to one side: its colour times (1 + cos) / 2 of the angle to its axis."""

    TYPE: ClassVar[str] = "beacon"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("position", "vector", "Where it is, metres.", unit="m", scale="unbounded", moves="shadows"),
        Row("axis", "direction", "Where it shines most.", nonzero=True, scale="unbounded"),
        Row("colour", "colour", "Linear RGB along the axis.", lowest=0),
    )

    position: Float[Array, "3"]
    axis: Float[Array, "3"]
    colour: Float[Array, "3"]
    name: str | None = eqx.field(static=True)

    def __init__(self, position, axis, colour, name=None, place="beacon"):
        self.name = name
        read_rows(self, place, position=position, axis=axis, colour=colour)

    def arriving(self, point):
        to_light = vec3(self.position) - point
        direction = normalise(to_light)
        share = 0.5 * (1 - dot(direction, normalise(vec3(self.axis))))
        return direction, length(to_light), vec3(self.colour) * share


class Ripples(AbstractTexture):
    """1 + depth sin(2 pi x / wavelength)."""

    TYPE: ClassVar[str] = "ripples"
    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("depth", "number", "Of the waves.", lowest=0, highest=1),
        Row("wavelength", "number", "Metres.", unit="m", lowest=0, excluded=True),
    )

    depth: Float[Array, ""]
    wavelength: Float[Array, ""]

    def __init__(self, depth, wavelength, place="texture"):
        read_rows(self, place, depth=depth, wavelength=wavelength)

    def at(self, point):
        wave = 1 + self.depth * jnp.sin(2 * jnp.pi * point.position.x / self.wavelength)
        return Vec3(wave, wave, wave)


class Dawn(AbstractBackground):
    """Brighter towards +x."""

    TYPE: ClassVar[str] = "dawn"
    ROWS: ClassVar[tuple[Row, ...]] = (Row("colour", "colour", "Linear RGB at the brightest.", lowest=0),)

    colour: Float[Array, "3"]

    def __init__(self, colour, place="background"):
        read_rows(self, place, colour=colour)

    def seen(self, direction):
        return vec3(self.colour) * (0.5 * (1 + direction.x))

    def brightest(self):
        return np.asarray(self.colour, np.float64)


class Panorama(AbstractCamera):
    """All around: a column is an angle, a row a height on a cylinder."""

    TYPE: ClassVar[str] = "panorama"
    ROWS: ClassVar[tuple[Row, ...]] = (
        *VIEW,
        PRINCIPAL_POINT,
        Row(
            "stretch",
            "number",
            "Height of the picture on a cylinder of radius 1.",
            lowest=0,
            excluded=True,
            scale="log",
        ),
    )

    look_from: Float[Array, "3"]
    look_at: Float[Array, "3"]
    up: Float[Array, "3"]
    principal_point: Float[Array, "2"] | None
    stretch: Float[Array, ""]
    width: int = eqx.field(static=True)
    height: int = eqx.field(static=True)
    full: tuple = eqx.field(static=True)
    crop: tuple | None = eqx.field(static=True)

    def __init__(
        self, look_from, look_at, stretch, width, height, up=(0, 1, 0), principal_point=None, crop=None, place="camera"
    ):
        self._stand(place, look_from, look_at, up, width, height, principal_point, crop)
        read_rows(self, place, stretch=stretch)

    def through(self, column, row):
        position, ahead, right, top = self.axes()
        angle = 2 * jnp.pi * (column / self.full[0] - 0.5)
        _, upwards = self.offset(column, row, self.stretch)
        direction = normalise(ahead * jnp.cos(angle) + right * jnp.sin(angle) + top * upwards)
        return Ray(position * jnp.ones_like(direction.x), direction)

    def apart(self, origin):
        angle = self.stretch / self.full[1]
        return length(origin - vec3(self.look_from)) * angle, angle * jnp.ones_like(origin.x)


GLOW_ROW = Row(
    "k_e", "number or colour", "light of its own", symbol="k_e", default=0.0, lowest=0.0, fit_bounds=(0.0, 1.0)
)
GLOW = Effect(
    "glow",
    lambda asked: asked.first_with("k_e"),
    "no object has k_e > 0",
    coefficients=("k_e",),
    adds=lambda point: point.coefficients["k_e"],
    brightest=lambda scene, material: np.broadcast_to(np.asarray(scene.materials[material].k_e, np.float64), 3),
)


@contextmanager
def known():
    """All of them, for the length of a `with` block."""
    with ExitStack() as stack:
        kinds = (OBJECTS, Coin), (LIGHTS, Beacon), (TEXTURES, Ripples), (BACKGROUNDS, Dawn), (CAMERAS, Panorama)
        for registry, kind in kinds:
            stack.enter_context(registry.including(kind))
        stack.enter_context(including_coefficient(GLOW_ROW))
        stack.enter_context(including_effect(GLOW))
        yield dw


TOML = """
[scene]
background = { type = "dawn", colour = [0.2, 0.3, 0.4] }
[[camera]]
look_from = [0, 1, 5]
look_at = [0, 0, 0]
vfov_deg = 40
width = 24
height = 18
[[camera]]
name = "around"
type = "panorama"
look_from = [0, 1, 5]
look_at = [0, 1, 0]
stretch = 2
width = 24
height = 18
crop = [4, 0, 16, 18]
[[light]]
type = "beacon"
name = "tower"
position = [2, 4, 3]
axis = [-1, -2, -1]
colour = [0.9, 0.8, 0.7]
[[texture]]
name = "waves"
type = "ripples"
depth = 0.3
wavelength = 0.8
[[material]]
name = "paint"
k_d = [0.5, 0.4, 0.3]
k_d_texture = "waves"
k_e = 0.1
[[material]]
name = "steel"
k_d = 0.2
k_s = 0.4
[[object]]
name = "plate"
type = "coin"
centre = [0, -0.5, 0]
normal = [0.1, 1, 0.2]
radius = 1.4
material = "paint"
[[object]]
name = "ball"
type = "sphere"
centre = [0.4, 0.4, 0.2]
radius = 0.6
material = "steel"
"""
