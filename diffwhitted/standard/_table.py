"""A table with glass on it: a tumbler, a ball of glass, one of steel."""

import numpy as np

from ..scene import Camera, Checker, Cylinder, GradientBackground, Material, Mesh, Plane, PointLight, Sphere
from ._parts import Parts

TOP = 0.75
"""Height of the round table's top, metres."""
THICK = 0.025
PROFILE = (
    (0.0, 0.0), (0.026, 0.0), (0.030, 0.003), (0.033, 0.04), (0.037, 0.08), (0.040, 0.119), (0.0395, 0.1205),
    (0.0385, 0.1205), (0.038, 0.119), (0.035, 0.08), (0.031, 0.04), (0.027, 0.014), (0.022, 0.010), (0.0, 0.009),
)  # fmt: skip
"""Radius and height of the tumbler's wall, from the middle below over the outer side to the middle within, metres."""


def table(size: int) -> Parts:
    """The tumbler is a mesh of `size` steps around."""
    vertices, faces = turned_profile(np.asarray(PROFILE), size)
    return dict(
        objects=[
            Plane("floor", (0, 1, 0), 0, "floor"),
            Cylinder("top", (0, TOP - THICK, 0), (0, TOP, 0), 0.3, "wood"),
            Cylinder("leg", (0, 0, 0), (0, TOP - THICK, 0), 0.03, "wood"),
            Mesh("tumbler", vertices + [-0.09, TOP + 1e-4, 0.05], faces, "glass", shading="phong"),
            Sphere("glass ball", (0.07, TOP + 0.0501, 0.12), 0.05, "glass"),
            Sphere("steel ball", (0.05, TOP + 0.0701, -0.12), 0.07, "steel"),
        ],
        materials={
            "wood": Material(k_a=(0.16, 0.09, 0.05), k_d=(0.5, 0.28, 0.14), k_h=0.15, k_s=0.06, phong_exponent=60),
            "floor": Material(k_a=0.2, k_d=0.7, k_a_texture="tiles", k_d_texture="tiles"),
            "glass": Material(k_h=0.5, k_s=0.08, k_t=0.92, phong_exponent=300, refractive_index=1.5),
            "steel": Material(k_d=0.08, k_h=0.6, k_s=0.7, phong_exponent=120),
        },
        textures={"tiles": Checker(((0.75, 0.75, 0.72), (0.25, 0.3, 0.36)), 0.3, "xz")},
        lights=[
            PointLight((-1.2, 2.4, 1.0), (0.75, 0.72, 0.68), name="lamp"),
            PointLight((1.8, 1.9, 1.4), (0.3, 0.32, 0.36), name="window"),
        ],
        cameras={"main": Camera((0.16, TOP + 0.28, 0.75), (0.0, TOP + 0.03, 0.0), 38, 640, 480)},
        background=GradientBackground((0.35, 0.35, 0.38), (0.75, 0.8, 0.9)),
        max_depth=8,
        shadows="tinted",
        footprint=1,
    )


def turned_profile(profile: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of the closed body that a profile (n, 2) of radii and heights sweeps about y; both ends of
    the profile lie on the axis.
    """
    around = 2 * np.pi / steps * np.arange(steps)
    ring = np.stack([np.cos(around), np.zeros(steps), -np.sin(around)], axis=-1)
    inner = profile[1:-1]
    rings = (inner[:, :1, None] * ring + inner[:, 1:, None] * [0, 1, 0]).reshape(-1, 3)
    below, above = len(rings), len(rings) + 1
    here = np.arange(steps)
    after, last = (here + 1) % steps, steps * (len(inner) - 1)
    faces = [np.stack([np.full(steps, below), after, here], axis=-1)]
    for first in steps * np.arange(len(inner) - 1):
        lower, upper = (first + here, first + after), (first + steps + here, first + steps + after)
        faces += [np.stack([lower[0], lower[1], upper[1]], axis=-1), np.stack([lower[0], upper[1], upper[0]], axis=-1)]
    faces.append(np.stack([np.full(steps, above), last + here, last + after], axis=-1))
    ends = np.asarray([[0, profile[0, 1], 0], [0, profile[-1, 1], 0]])
    return np.concatenate([rings, ends]), np.concatenate(faces)
