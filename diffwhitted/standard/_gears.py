"""Gears: layers of interlocking gears, some of them of glass."""

from math import pi

import numpy as np

from ..scene import AbstractObject, Material, Mesh, Polygon
from ._parts import Parts, paint, usual_camera, usual_scene

TEETH = 36
IN_TOOTH = (-0.19, 0.19, 0.3, 0.7)
"""The angles of a tooth's four corners, in those of one tooth: two outer ones, two inner ones."""
LIGHTS = ((2, 4, 4), (-2, 4, 3), (2, -2.5, 2.5), (-1, -4, 2), (-1.111, -2.121, 2.626))
FLOOR = ((2, 2, 0), (-2, 2, 0), (-2, -2, 0), (2, -2, 0))


def gears(size: int) -> Parts:
    """size^3 gears over a floor; every fifth transmits light, with index 1.1."""
    pitch = 1 / (size - (size - 1) * 0.05)
    thickness = min(0.1, 0.5 / size)
    objects: list[AbstractObject] = [Polygon("floor", FLOOR, "floor")]
    materials = {"floor": paint((1, 0.85, 0.7), 0.3, 0.6, 37)}
    for i, j, k in np.ndindex(size, size, size):
        name = f"gear {i} {j} {k}"
        middle = [-1 + pitch + 1.9 * pitch * i, -1 + pitch + 1.9 * pitch * j, 1 - k / size]
        vertices, faces = gear(0.995 * pitch, 0.9 * pitch, thickness, pi / TEETH * ((i + j + k) % 2))
        objects.append(Mesh(name, vertices + middle, faces, name))
        materials[name] = _material(i, j, k)
    return usual_scene(objects, materials, LIGHTS, usual_camera((-1.1, -2.1, 2.6), (0, 0, 0)))


def gear(outer: float, inner: float, thickness: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (8 t, 3) and triangles of a gear of t teeth about z, turned by an angle in radians; closed."""
    around = angle + 2 * pi / TEETH * (np.arange(TEETH)[:, None] + IN_TOOTH).ravel()
    radii = np.tile([outer, outer, inner, inner], TEETH)
    rim = np.stack([radii * np.cos(around), radii * np.sin(around), np.full(4 * TEETH, thickness / 2)], axis=-1)
    count = len(rim)
    # The top: a fan within the inner corners, and each tooth upon it.
    tooth = 4 * np.arange(TEETH)[:, None]
    within = np.sort(np.concatenate([tooth + 2, tooth + 3]).ravel())
    fan = np.stack([np.full(len(within) - 2, within[0]), within[1:-1], within[2:]], axis=-1)
    upon = np.concatenate([tooth + three for three in ([-1, 0, 1], [-1, 1, 2])]) % count
    top = np.concatenate([fan, upon])
    # The copy below looks down, and the sides outwards.
    here = np.arange(count)
    after = (here + 1) % count
    sides = [np.stack(three, axis=-1) for three in ((here, here + count, after + count), (here, after + count, after))]
    return np.concatenate([rim, rim * [1, 1, -1]]), np.concatenate([top, top[:, ::-1] + count, *sides])


def _material(i: int, j: int, k: int) -> Material:
    colour = np.asarray([
        (5 / 7 * (3 * i + 2 * j + k + 1)) % 1,
        (3 / 7 * (3 * j + 2 * k + i + 1)) % 1,
        (2 / 7 * (3 * k + 2 * i + j + 1)) % 1,
    ]) + 0.01  # fmt: skip
    colour = colour / colour.max()
    if (4 * i + 2 * j + k) % 5:
        return paint(colour, 1.0)
    return paint(colour, 0.2, k_t=0.8, refractive_index=1.1)
