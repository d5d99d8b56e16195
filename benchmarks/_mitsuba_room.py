"""Renders the box of `bleeding.toml`, without its mirror ball, by Mitsuba 3's path tracer; run by its interpreter.

python benchmarks/_mitsuba_room.py SIDE SAMPLES OUT.npz: the picture of SIDE x SIDE pixels, the mean of two of SAMPLES
samples a pixel, and the standard deviation of its noise from what they differ by.
"""

import sys
import time

import mitsuba
import numpy as np

mitsuba.set_variant("scalar_rgb")
WALLS = {
    "floor": ("white", [(0, 0, 0), (0, 0, 2), (2, 0, 2), (2, 0, 0)]),
    "ceiling": ("white", [(0, 2, 0), (2, 2, 0), (2, 2, 2), (0, 2, 2)]),
    "back": ("white", [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]),
    "left": ("red", [(0, 0, 0), (0, 2, 0), (0, 2, 2), (0, 0, 2)]),
    "right": ("green", [(2, 0, 0), (2, 0, 2), (2, 2, 2), (2, 2, 0)]),
}
COLOURS = {"white": (0.72, 0.72, 0.72), "red": (0.57, 0.06, 0.05), "green": (0.11, 0.43, 0.12)}
LAMP = [(0.65, 1.95, 0.65), (1.35, 1.95, 0.65), (1.35, 1.95, 1.35), (0.65, 1.95, 1.35)]
EMISSION = (9.0, 7.5, 5.0)


def matte(colour):
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(colour)}}}


def quad(corners, **more):
    """A rectangle, its front the side from which the corners run counter-clockwise."""
    first, second, _, last = (np.asarray(corner, float) for corner in corners)
    along, across = (second - first) / 2, (last - first) / 2
    normal = np.cross(along, across)
    matrix = np.eye(4)
    matrix[:3] = np.stack([along, across, normal / np.linalg.norm(normal), first + along + across], axis=1)
    return {"type": "rectangle", "to_world": mitsuba.ScalarTransform4f(matrix.tolist()), **more}


def scene(side: int):
    transform, glow = mitsuba.ScalarTransform4f, {"type": "area", "radiance": {"type": "rgb", "value": list(EMISSION)}}
    black = matte((0, 0, 0))
    above = [(x, y + 1e-4, z) for x, y, z in LAMP[::-1]]
    block = transform().translate([1.375, 0.275, 1.175]).scale([0.275, 0.275, 0.275])
    return mitsuba.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 40, "rr_depth": 12},
            "sensor": {
                "type": "perspective", "fov": 36.0, "fov_axis": "y",
                "to_world": transform().look_at(origin=[1, 1, 5.3], target=[1, 1, 0], up=[0, 1, 0]),
                "film": {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}},
            },
            "block": {"type": "cube", "to_world": block, "bsdf": matte(COLOURS["white"])},
            "lamp": quad(LAMP, emitter=glow, bsdf=black),
            "back of the lamp": quad(above, emitter=glow, bsdf=black),
        }
        | {name: quad(corners, bsdf=matte(COLOURS[colour])) for name, (colour, corners) in WALLS.items()}
    )  # fmt: skip


if __name__ == "__main__":
    side, samples, out = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    room, start = scene(side), time.perf_counter()
    one, other = (np.asarray(mitsuba.render(room, spp=samples, seed=seed), np.float64) for seed in (1, 2))
    seconds = time.perf_counter() - start
    np.savez(out, image=(one + other) / 2, noise=np.sqrt(np.mean((one - other) ** 2)) / 2, seconds=seconds)
    print(f"{seconds:.1f} s, mean {np.mean(one):.4f}, noise {np.sqrt(np.mean((one - other) ** 2)) / 2:.2g}")
