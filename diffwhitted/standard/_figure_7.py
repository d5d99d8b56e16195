"""Whitted's figure 7: a glass ball and a small mirroring one over a checkerboard.

T. Whitted, "An improved illumination model for shaded display", CACM 23(6), 1980. The paper states no numbers of that
scene: these are ours, after the picture.
"""

from ..scene import Camera, Checker, ConstantBackground, Material, PointLight, Polygon, Sphere
from ._parts import Parts

SIDE, BACK, FRONT = 3.0, -9.0, 3.0
"""Where the board ends, metres: half its width, and along z."""


def figure_7(size: int) -> Parts:
    """The board has `size` squares across."""
    corners = [[-SIDE, 0, FRONT], [SIDE, 0, FRONT], [SIDE, 0, BACK], [-SIDE, 0, BACK]]
    return dict(
        objects=[
            Sphere("glass ball", (0.35, 1.35, 0.6), 0.95, "glass"),
            Sphere("small ball", (-1.05, 0.85, -1.3), 0.7, "mirror"),
            Polygon("board", corners, "board"),
        ],
        materials={
            "glass": Material(k_d=0.02, k_h=0.4, k_s=0.08, k_t=0.9, phong_exponent=200, refractive_index=1.5),
            "mirror": Material(k_a=0.1, k_d=(0.3, 0.28, 0.28), k_h=0.6, k_s=0.5, phong_exponent=60),
            "board": Material(k_a=0.3, k_d=0.8, k_a_texture="squares", k_d_texture="squares"),
        },
        textures={"squares": Checker(((0.9, 0.07, 0.04), (0.95, 0.85, 0.06)), 2 * SIDE / size, "xz")},
        lights=[PointLight((-3.5, 8, 5), (0.95, 0.95, 0.95), name="lamp")],
        cameras={"main": Camera((0.0, 1.9, 6.2), (0.0, 1.0, 0.0), 36, 640, 480)},
        background=ConstantBackground((0.13, 0.35, 0.68)),
        ambient=(0.9, 0.9, 0.9),
        max_depth=6,
        shadows="tinted",
        footprint=1,
    )
