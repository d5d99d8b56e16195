"""Scenes that both tests and benchmarks measure."""

import diffwhitted as dw


def nested_glass(vfov_deg: float = 30, width: int = 320, height: int = 240) -> dw.Scene:
    """A glass sphere in a glass sphere, on a floor under a sky."""
    objects = [
        dw.Sphere("outer", (0, 0, 0), 1, "outer"),
        dw.Sphere("inner", (0.1, 0, 0), 0.6, "inner"),
        dw.Plane("floor", (0, 1, 0), -1, "floor"),
    ]
    materials = {
        "outer": dw.Material(k_s=0.1, k_t=0.85, k_h=0.0, refractive_index=1.5),
        "floor": dw.Material(k_d=0.6, k_a=0.1),
        "inner": dw.Material(k_s=0.1, k_t=0.85, k_h=0.2, refractive_index=1.2),
    }
    return dw.Scene(
        objects=objects,
        materials=materials,
        lights=[dw.PointLight((0, 5, 3), (1, 1, 1))],
        background=dw.ConstantBackground((0.2, 0.3, 0.5)),
        cameras={"main": dw.Camera((0.3, 0.5, 6), (0, 0, 0), vfov_deg, width, height)},
    )
