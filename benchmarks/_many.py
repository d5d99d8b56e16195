"""A scene of many triangles: a bumpy ball over a floor."""

import numpy as np

import diffwhitted
from references.balls import ball

SKY = diffwhitted.ConstantBackground((0.078, 0.361, 0.753))
BUMPS = ((7, 6, 8, 0.04), (25, 23, 0, 0.01))


def bumpy(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and 20 * 4**levels triangles of a ball with bumps."""
    vertices, faces = ball(levels)
    x, y, z = vertices.T
    height = np.ones(len(vertices))
    for a, b, c, most in BUMPS:
        height += most * np.sin(a * x) * np.sin(b * y + 1) * np.cos(c * z + 2)
    return vertices * height[:, None], faces


def mirror_ball(levels: int) -> diffwhitted.Scene:
    """The bumpy ball as a mirror over a floor, under two lamps."""
    return diffwhitted.Scene(
        objects=[
            diffwhitted.Mesh("ball", *bumpy(levels), "mirror"),
            diffwhitted.Plane("floor", (0, 1, 0), -1.1, "floor"),
        ],
        materials={
            "mirror": diffwhitted.Material(k_d=0.3, k_s=0.6, k_h=0.3, phong_exponent=30),
            "floor": diffwhitted.Material(k_d=(0.8, 0.6, 0.3)),
        },
        lights=[diffwhitted.PointLight(at, (0.7,) * 3) for at in ((3, 4, 3), (-4, 3, 1))],
        cameras={"main": diffwhitted.Camera((0, 1.2, 4.2), (0, 0, 0), 40, 640, 480)},
        background=SKY,
    )
