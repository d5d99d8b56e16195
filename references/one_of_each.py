"""A scene with one of each kind: for tests that run over all of its numbers."""

import functools

import numpy as np

import diffwhitted as dw


@functools.cache
def one_of_each() -> dw.Scene:
    """Every shape, light, texture and background, and what nothing wears, sees or is made of."""
    return dw.Scene(
        objects=[
            dw.Sphere("ball", (-0.6, 0.1, 0), 0.9, "glazed"),
            dw.Polygon("sail", [(0.6, -0.7, -0.3), (2.1, -0.6, -0.8), (1.0, 1.3, -0.7)], "matte"),
            dw.Polygon("board", [(-2.6, -0.9, -1.6), (-1.2, -0.9, -2), (-1.2, 1.1, -2), (-2.6, 1.1, -1.6)], "matte"),
            dw.Plane("ground", (0.1, 2.0, 0.05), -2.0, "floor"),
        ],
        materials={
            "glazed": dw.Material(
                k_a=(0.05, 0.1, 0.1), k_d=(0.4, 0.3, 0.2), k_h=0.3, k_s=0.15, k_t=0.3, refractive_index=1.2,
                phong_exponent=12,
            ),
            "matte": dw.Material(k_a=0.1, k_d=(0.3, 0.6, 0.8), k_d_texture="print", highlight="off"),
            "floor": dw.Material(k_a=0.1, k_d=0.8, k_d_texture="tiles", highlight="off"),
            "spare": dw.Material(k_d=0.5),
        },
        lights=[
            dw.PointLight((2, 3.5, 3), (0.9, 0.8, 0.7), attenuation=(0.4, 0.1, 0.02), name="lamp"),
            dw.DirectionalLight((-1, 2, 1.5), (0.3, 0.4, 0.5), name="sun"),
        ],
        textures={
            "tiles": dw.Checker([(0.9, 0.3, 0.2), (0.2, 0.5, 0.9)], size=1.3, axes="xz"),
            "print": dw.ImageTexture(
                np.random.default_rng(2).uniform(0.7, 1, (5, 6, 3)), mapping="planar", origin=(-2.6, -0.9, -1.6),
                edge_u=(2.8, 0, -0.8), edge_v=(0, 2.4, 0), wrap="mirror",
            ),
            "unworn": dw.Checker([(1, 1, 1), (0, 0, 0)]),
        },
        cameras={
            "main": dw.Camera((0.2, 0.9, 5.5), (0, 0, 0), 46, 24, 18),
            "side": dw.Camera((5, 1, 0), (0, 0, 0), 40, 24, 18),
        },
        background=dw.GradientBackground((0.5, 0.4, 0.3), (0.2, 0.4, 0.8)),
        ambient=(0.8, 0.9, 1.0),
        shadows="tinted",
        max_depth=3,
        precision="float64",
    )  # fmt: skip
