"""The shapes of three_spheres.toml in Mitsuba 3, and what is timed there.

`python -m benchmarks._mitsuba_scene render` prints one line of JSON. It needs `mitsuba` and `numpy`, and nothing of this
project: it runs under an interpreter of its own.

What is alike: spheres, plane, checkerboard, camera, two point lights, a smooth dielectric of the same index, smooth
mirrors blended with diffuse colour by k_s. What is not: Mitsuba traces one random path a sample instead of
the whole tree; its mirror and glass weights are Fresnel's; point lights fade with distance (here scaled to
Whitted's brightness in the middle of the scene); the background lights surfaces and surfaces light each other;
there is no ambient term, no Phong highlight, and glass casts a black shadow.
"""

import json
import sys
import time
import tomllib
from math import pi
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

VARIANTS = ("llvm_ad_rgb", "scalar_rgb")
REFERENCE_SAMPLES = 512


def choose_variant() -> str:
    """LLVM where its library is found, else the interpreter of scalars."""
    for variant in VARIANTS:
        try:
            mi.set_variant(variant)
            mi.Float(1) + mi.Float(1)
            return variant
        except Exception as error:  # noqa: BLE001
            print(f"{variant}: {error}", file=sys.stderr)
    raise SystemExit("no variant of Mitsuba 3 works here")


def scene_of(width: int | None = None, height: int | None = None, integrator: str = "path"):
    """The scene file as a Mitsuba scene."""
    data = tomllib.loads((Path(__file__).parent / "three_spheres.toml").read_text())
    camera, textures = data["camera"][0], {t["name"]: t for t in data.get("texture", [])}
    materials = {m["name"]: _material(m, textures) for m in data["material"]}
    scene = {
        "type": "scene",
        "integrator": {"type": integrator, "max_depth": data["scene"]["max_depth"] + 1, "rr_depth": 1000},
        "sky": {"type": "constant", "radiance": _rgb(data["scene"]["background"])},
        "camera": _camera(camera, width or camera["width"], height or camera["height"]),
    }
    for number, light in enumerate(data["light"]):
        fade = sum(x * x for x in light["position"])
        scene[f"light{number}"] = {"type": "point", "position": light["position"],
                                   "intensity": _rgb([pi * fade * c for c in light["colour"]])}
    for thing in data["object"]:
        scene[thing["name"]] = _shape(thing) | {"material": materials[thing["material"]]}
    return mi.load_dict(scene)


def _rgb(value) -> dict:
    return {"type": "rgb", "value": value}


def _camera(camera: dict, width: int, height: int) -> dict:
    look = mi.ScalarTransform4f().look_at(camera["look_from"], camera["look_at"], camera["up"])
    return {"type": "perspective", "fov": camera["vfov_deg"], "fov_axis": "y", "to_world": look,
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"}}


def _shape(thing: dict) -> dict:
    if thing["type"] == "sphere":
        return {"type": "sphere", "center": thing["centre"], "radius": thing["radius"]}
    far = 1000.0
    place = mi.ScalarTransform4f().translate([0, thing["offset"], 0]).rotate([1, 0, 0], -90).scale(far)
    return {"type": "rectangle", "to_world": place}


def _material(material: dict, textures: dict) -> dict:
    if material.get("k_t"):
        return {"type": "dielectric", "int_ior": material["refractive_index"], "ext_ior": 1.0,
                "specular_transmittance": _rgb(material["k_t"])}
    colour = _rgb(material["k_d"]) if "k_d_texture" not in material else _checker(textures[material["k_d_texture"]])
    diffuse = {"type": "diffuse", "reflectance": colour}
    if not material.get("k_s"):
        return diffuse
    mirror = {"type": "conductor", "material": "none"}
    return {"type": "blendbsdf", "weight": material["k_s"], "diffuse": diffuse, "mirror": mirror}


def _checker(texture: dict) -> dict:
    # A texture's period is two cells; the rectangle spans 2000 m.
    even, odd = map(_rgb, texture["colours"])
    return {"type": "checkerboard", "color0": odd, "color1": even, "to_uv": mi.ScalarTransform3f().scale(1000 / texture["size"])}


def render(variant: str) -> dict:
    """Seconds of single-sample pictures, and how far they are from one of many samples."""
    scene = scene_of()

    def picture(seed: int, samples: int):
        image = mi.render(scene, spp=samples, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        return image

    picture(0, 1)
    seconds, noise = [], []
    reference = np.array(picture(1000, REFERENCE_SAMPLES))
    for seed in range(1, 16):
        begun = time.perf_counter()
        image = picture(seed, 1)
        seconds.append(time.perf_counter() - begun)
        noise.append(float(np.sqrt(np.mean((np.array(image) - reference) ** 2))))
    return {"seconds": seconds, "noise": float(np.median(noise)), "mean": reference.mean(axis=(0, 1)).tolist()}


if __name__ == "__main__":
    chosen = choose_variant()
    print(json.dumps({"version": mi.__version__, "variant": chosen} | {"render": render}[sys.argv[1]](chosen)))
