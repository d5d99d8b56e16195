"""What the standard scenes have in common: their camera, lights, materials, and turns.

The rules are those of E. Haines, "A proposal for standard graphics environments", 1987 (databases 3.14, CC0).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import acos, atan, cos, degrees, log, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np

from ..scene import AbstractObject, Camera, ConstantBackground, Material, PointLight

Parts = dict[str, Any]
"""What `Scene` takes, by name."""

SKY = (0.078, 0.361, 0.753)
PICTURE = 512
DEEPEST = 5
THREE_AROUND = tuple(2 * pi / 3 * k for k in range(3))
TETRAHEDRAL = acos(-1 / 3)
"""The angle between two directions from the middle of a tetrahedron to its corners, radians."""


@dataclass(frozen=True)
class StandardScene:
    """One entry of the registry."""

    make: Callable[[int], Parts]
    """The scene of a size, in its parts."""
    size: int
    """The size that it has unless another is asked for."""
    largest: int
    """A larger one would not fit into memory."""
    about: str
    """What is to be seen, and what the size is."""


def view_angle(angle_deg: float, rows: int) -> float:
    """The full vertical angle of a camera, degrees, whose stated angle spans the middles of the first and last row.

    tan(vfov / 2) = tan(angle / 2) rows / (rows - 1). One row alone has the angle itself.
    """
    wider = rows / (rows - 1) if rows > 1 else 1.0
    return degrees(2 * atan(tan(radians(angle_deg) / 2) * wider))


def usual_camera(look_from, look_at, up=(0.0, 0.0, 1.0)) -> Camera:
    """45 degrees, 512 x 512 pixels."""
    return Camera(look_from, look_at, view_angle(45, PICTURE), PICTURE, PICTURE, up)


def usual_strength(lights: int) -> float:
    """sqrt(L) / (2 L): of each of L lights, and of the ambient light; 0 without any."""
    return sqrt(lights) / (2 * lights) if lights else 0.0


def usual_lights(places: Sequence) -> list[PointLight]:
    """White lights in these places (n, 3)."""
    colour = np.full(3, usual_strength(len(places)))
    return [PointLight(place, colour) for place in places]


def exponent_of(angle_deg: float) -> float:
    """The exponent of a highlight that has half its strength at an angle: n = ln(1/2) / ln(cos angle)."""
    return log(0.5) / log(cos(radians(angle_deg)))


def paint(colour, k_d: float, k_s: float = 0.0, angle_deg: float | None = None, **more) -> Material:
    """A material by its colour and its shares: k_a = k_d = share * colour, k_s and k_h white."""
    sent = k_d * np.asarray(colour, np.float64)
    exponent = {} if angle_deg is None else {"phong_exponent": exponent_of(angle_deg)}
    return Material(k_a=sent, k_d=sent, k_s=k_s, **exponent, **more)


def usual_scene(objects: Sequence[AbstractObject], materials: dict[str, Material], lights, camera: Camera) -> Parts:
    """The scene by the rules: depth 5, opaque shadows, total reflection as in Whitted, the common background."""
    return dict(
        objects=objects,
        materials=materials,
        lights=usual_lights(lights),
        cameras={"main": camera},
        background=ConstantBackground(SKY),
        ambient=np.full(3, usual_strength(len(lights))),
        max_depth=DEEPEST,
        shadows="opaque",
        total_internal_reflection="whitted",
    )


def turned(axis, angle: float) -> np.ndarray:
    """The matrix (3, 3) that turns row vectors about an axis by an angle, radians: x to y about z.

    v M with M = cos I + (1 - cos) a a^T + sin [a]_x^T (Rodrigues).
    """
    a = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    across = np.asarray([[0, a[2], -a[1]], [-a[2], 0, a[0]], [a[1], -a[0], 0]])
    return cos(angle) * np.eye(3) + (1 - cos(angle)) * np.outer(a, a) + sin(angle) * across


X, Y, Z = np.eye(3)
