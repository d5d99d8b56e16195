"""What a fit changes in a number of the scene: the numbers one by one, a direction by its angles, points within their
plane.

A row says which (`Row.free_by`):

- each: every number is an unknown.
- turn: a direction, or that from another point to this one, turns by (u, v) degrees in its tangent plane; its length
  stays.
- roll: a direction turns by `roll` degrees about the line between two points, such as the `up` of a camera about its
  view.
- flat: points of a plane polygon move by (u, v) metres within that plane; those of a triangle freely.

Angles and moves are counted from the scene that the fit was given, where they are 0.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from diffwhitted.scene import Parameter, Scene

from .._errors import FitError

ACROSS = ("u", "v")
"""The two ways in a tangent plane."""
SMALL = 1e-8
"""Square of an angle in radians below which its sine and cosine are those of their series."""


class Part(NamedTuple):
    """One unknown within a parameter."""

    component: str
    """Its name after that of the parameter; empty for one number."""
    unit: str
    counted: bool
    """Counted from the given scene."""


def parts_of(scene: Scene, parameter: Parameter) -> tuple[Part, ...]:
    """The unknowns of a parameter, in order."""
    row = parameter.row
    if row.kind == "texels":
        raise FitError(
            f"free: {parameter.name} is a whole picture; it has a fit of its own: fitting.fit_texture(scene, "
            f"{parameter.owner!r}, ...), or on the command line fit SCENE --texture {parameter.owner}"
        )
    match _way(scene, parameter):
        case "turn":
            return tuple(Part(way, "deg", True) for way in ACROSS)
        case "roll":
            return (Part("roll", "deg", True),)
        case "flat":
            count = len(parameter.value(scene))
            return tuple(Part(f"{k}.{way}", row.unit, True) for k in range(count) for way in ACROSS)
    return tuple(Part(name, row.unit, False) for name in parameter.components(scene) or ("",))


def read(scene: Scene, parameter: Parameter, other: Scene) -> np.ndarray:
    """The unknowns of a parameter in another scene, float64; angles and moves from those of `scene`."""
    value = np.asarray(parameter.value(other), np.float64)
    match _way(scene, parameter):
        case "turn":
            base, new = (_direction(s, parameter) for s in (scene, other))
            length, ways = np.linalg.norm(new), np.asarray(_frame(base), np.float64)
            along, u, v = ways @ new / (length or 1)
            flat = math.hypot(u, v)
            share = math.atan2(flat, along) / flat if flat else 0.0
            return np.rad2deg(np.asarray([u, v]) * share)
        case "roll":
            axis, across, upwards = _upright(scene, parameter)
            return np.rad2deg(np.atleast_1d(np.arctan2(across @ value, upwards @ value)))
        case "flat":
            base = np.asarray(parameter.value(scene), np.float64)
            return ((value - base) @ np.asarray(_plane(base), np.float64).T).reshape(-1)
    return value.reshape(-1)


def moved(
    scene: Scene, other: Scene, parameter: Parameter, numbers: Sequence[int], values: Float[Array | np.ndarray, "k"]
) -> Array | np.ndarray:
    """The value of a parameter in `other` with those of its unknowns that are numbered; differentiable in the values.

    `scene` is the one from which angles and moves are counted.
    """
    value, row = jnp.asarray(parameter.value(other)), parameter.row
    way = _way(scene, parameter)
    if way == "each":
        if len(numbers) == value.size:
            return values.reshape(value.shape)
        where = np.unravel_index(np.asarray(numbers), value.shape)
        return value.at[where].set(values)
    count = {"turn": 2, "roll": 1, "flat": 2 * value.shape[0]}[way]
    whole = jnp.zeros(count, values.dtype).at[np.asarray(numbers)].set(values)
    if way == "flat":
        return value + whole.reshape(-1, 2) @ jnp.stack(_plane(value))
    if way == "roll":
        axis, across, upwards = (jnp.asarray(a, value.dtype) for a in _upright(scene, parameter))
        angle = jnp.deg2rad(whole[0])
        along, size = axis * (axis @ value), jnp.linalg.norm(value - axis * (axis @ value))
        return along + size * (across * jnp.sin(angle) + upwards * jnp.cos(angle))
    direction = _direction(scene, parameter)
    turned = _turned(direction, jnp.deg2rad(whole))
    return turned if not row.about else parameter_of(other, parameter, row.about) + turned


def parameter_of(scene: Scene, parameter: Parameter, key: str) -> Array:
    """Another key of the same record."""
    return getattr(parameter.record(scene), key)


def _way(scene: Scene, parameter: Parameter) -> str:
    """How a parameter is free: three points lie in a plane however they move."""
    way = parameter.row.free_by
    return "each" if way == "flat" and len(parameter.value(scene)) == 3 else way


def _direction(scene: Scene, parameter: Parameter) -> Array:
    """What turns: the direction itself, or that from another point to this one."""
    value, about = parameter.value(scene), parameter.row.about
    return value - parameter_of(scene, parameter, about) if about else value


def _frame(direction) -> tuple[Array, Array, Array]:
    """Unit vectors: along a direction, and two across it."""
    along = direction / jnp.linalg.norm(direction)
    # Any axis far from the direction serves; which one, the derivative does not see.
    helper = jnp.eye(3, dtype=along.dtype)[jnp.argmin(jnp.abs(along))]
    u = jnp.cross(helper, along)
    u = u / jnp.linalg.norm(u)
    return along, u, jnp.cross(along, u)


def _turned(direction, angles: Float[Array, "2"]) -> Array:
    """A direction turned by the length of `angles` (radians) towards u and v of its frame; of the same length."""
    along, u, v = _frame(direction)
    square = angles @ angles
    small = square < SMALL
    angle = jnp.sqrt(jnp.where(small, 1, square))
    cosine = jnp.where(small, 1 - square / 2, jnp.cos(angle))
    sine_over = jnp.where(small, 1 - square / 6, jnp.sin(angle) / angle)
    turned = along * cosine + (u * angles[0] + v * angles[1]) * sine_over
    return turned * jnp.linalg.norm(direction)


def _upright(scene: Scene, parameter: Parameter) -> tuple[Array, Array, Array]:
    """Unit vectors: the axis of a roll, and across it the way to which a positive roll turns, and that of the
    direction itself.
    """
    start, end = (parameter_of(scene, parameter, key) for key in parameter.row.about.split())
    axis = (end - start) / jnp.linalg.norm(end - start)
    value = parameter.value(scene)
    upwards = value - axis * (axis @ value)
    upwards = upwards / jnp.linalg.norm(upwards)
    return axis, jnp.cross(axis, upwards), upwards


def _plane(points) -> tuple[Array, Array]:
    """Two unit vectors in the plane of a polygon, whose normal is Newell's sum."""
    spokes = points - points[0]
    normal = jnp.cross(spokes, jnp.roll(spokes, -1, axis=0)).sum(axis=0)
    return _frame(normal)[1:]
