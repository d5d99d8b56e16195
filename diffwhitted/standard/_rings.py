"""Rings: interlaced pentagons of cylinders and spheres, layer behind layer."""

from math import acos, cos, pi, radians, sin, tan

import numpy as np

from ..scene import AbstractObject, Cylinder, Polygon, SphereSet
from ._parts import Parts, X, Z, paint, turned, usual_camera, usual_scene

STEP = 1 / sin(radians(22.5))
"""Between two layers."""
RADIUS = 0.07412
"""Of the cylinders, metres."""
COLOURS = {
    "red": (1, 0, 0), "green": (0, 1, 0), "blue": (0, 0, 1), "cyan": (0, 1, 1), "magenta": (1, 0, 1),
    "yellow": (1, 1, 0),
}  # fmt: skip
LIGHTS = ((3, -STEP, 3), (-4, -STEP, 1), (2, -STEP, -4))


def rings(size: int) -> Parts:
    """`size` layers of 1, 4, 9, ... objects of 30 cylinders and 30 spheres, before a wall."""
    places = np.concatenate([_layer(depth) for depth in range(size)])
    objects: list[AbstractObject] = []
    for colour, corners in zip(COLOURS, pentagons(), strict=True):
        all_corners = places[:, None] + corners
        ends = all_corners.reshape(-1, 3), np.roll(all_corners, -1, axis=1).reshape(-1, 3)
        objects += [
            Cylinder(f"{colour} {number}", base, top, RADIUS, colour, capped=False)
            for number, (base, top) in enumerate(zip(*ends, strict=True), 1)
        ]
        objects.append(SphereSet(f"{colour} corners", ends[0], RADIUS, colour))
    eye, far = np.asarray([-1, -STEP, 0.5]), STEP * (size + 1)
    half = 1.01 * tan(radians(22.5)) * (far - eye[1])
    signs = np.asarray([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
    objects.append(Polygon("wall", [eye[0], far, eye[2]] + half * signs, "wall"))
    materials = {name: paint(colour, 0.5, 0.2, 37) for name, colour in COLOURS.items()}
    return usual_scene(objects, materials | {"wall": paint((1, 1, 1), 1.0)}, LIGHTS, usual_camera(eye, eye + [0, 1, 0]))


def pentagons() -> np.ndarray:
    """The corners (6, 5, 3) of the six rings of one object."""
    around = 2 * pi / 5 * np.arange(5)
    first = np.stack([np.cos(around), np.sin(around), 0 * around], axis=-1) / (1 + RADIUS)
    tilted = first @ turned(X, 2 * acos(cos(pi / 3) / sin(pi / 5)))
    return np.stack([first, *(tilted @ turned(Z, (2 * j + 1) * pi / 5) for j in range(5))])


def _layer(depth: int) -> np.ndarray:
    """The middles ((depth + 1)^2, 3) of a layer's objects."""
    along = 2.0 * np.arange(depth + 1) - depth
    x, z = (a.ravel() for a in np.meshgrid(along, along, indexing="ij"))
    return np.stack([x, np.full(len(x), STEP * (depth + 1)), z], axis=-1)
