"""A scene with all that other programs may be asked to say, and one in which nothing is unusual."""

import diffwhitted as dw


def everything(**settings) -> dw.Scene:
    """Every kind of thing, and materials that need more than one layer of another program's."""
    materials = {
        "floor": dw.Material(k_a=0.2, k_d=0.8, k_s=0.3, k_h=0.0, k_d_texture="tiles", k_s_texture="stripes"),
        "tinted glass": dw.Material(
            k_d=[0.1, 0.0, 0.05], k_a=[0.02, 0.03, 0.04], k_h=0.4, k_s=[0.1, 0.15, 0.2], k_t=[0.5, 0.8, 0.6],
            phong_exponent=30, refractive_index=1.3,
        ),
        "gold": dw.Material(k_a=[0.1, 0.05, 0.0], k_d=[0.3, 0.2, 0.1], k_s=[0.5, 0.4, 0.0], phong_exponent=20),
        "copper": dw.Material(
            k_d=[0.3, 0.2, 0.1], k_h=[0.6, 0.3, 0.1], k_s=0.1, phong_exponent=10, highlight="reflected"
        ),
        "sheet": dw.Material(k_a=0.3, k_d=0.2, k_t=[0.2, 0.5, 0.9], k_h=[0.2, 0.1, 0.0]),
        "dull": dw.Material(k_d=0.5, k_h=0.4, highlight="off"),
        "unused": dw.Material(k_d=0.5),
    }  # fmt: skip
    objects = [
        dw.Plane("ground", [0, 2, 0], -2, "floor"),
        dw.Sphere("glass ball", [-1.2, 0, 0.5], 0.9, "tinted glass"),
        dw.Sphere("gold ball", [1.3, -0.2, -0.5], 0.8, "gold"),
        dw.Sphere("copper ball", [0.1, -0.6, 1.4], 0.35, "copper"),
        dw.Polygon("window", [[0, -0.9, 1], [1.6, -0.9, 1.4], [1.6, 0.3, 1.4], [0, 0.3, 1]], "sheet"),
        dw.Polygon("sail", [[-3, -0.9, -2], [0, -0.9, -2.5], [-1.5, 1.6, -2.2]], "dull"),
        dw.Polygon("arrow", [[1, 1, -2], [3, 1, -2], [3, 3, -2], [2.5, 1.6, -2]], "copper"),
    ]
    stated = (
        dict(ambient=[1.0, 0.9, 0.8], background=dw.GradientBackground([0.3, 0.2, 0.1], [0.2, 0.4, 0.8]), max_depth=6)
        | settings
    )
    return dw.Scene(
        objects=objects,
        materials=materials,
        lights=[
            dw.PointLight([3, 5, 4], [0.7, 0.6, 0.5], attenuation=[1.0, 0.0, 0.01]),
            dw.PointLight([-4, 4, 2], 0.4, attenuation=[1.5, 0.05, 0.0]),
            dw.DirectionalLight([0.3, 2, 1], [0.2, 0.3, 0.3], name="sun"),
        ],
        textures={
            "tiles": dw.Checker([[0.9, 0.1, 0.1], [1, 1, 1]], 0.7, "xz"),
            "stripes": dw.Checker([[0.0, 0.0, 0.0], [1, 1, 0.5]], 1.1, "x"),
        },
        cameras={"main": dw.Camera([0.3, 0.8, 6], [0, 0.1, 0], 38, 160, 120, up=[0.1, 1, 0.2])},
        **stated,
    )
