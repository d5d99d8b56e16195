"""The shapes of three_spheres.toml in Mitsuba 3, and what is timed there.

`python -m benchmarks._mitsuba_scene render` (or `fit`) prints one line of JSON. It needs `mitsuba` and `numpy`, and
nothing of this project: it runs under an interpreter of its own.

What is alike: spheres, plane, checkerboard, camera, two point lights, a smooth dielectric of the same index, smooth
mirrors blended with diffuse colour. What is not: Mitsuba traces one random path a sample instead of
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
FIT_SIZE, FIT_SAMPLES, FIT_SECONDS = (320, 240), 4, 60.0
FITTED = (
    "glass.bsdf.specular_reflectance.value",
    "glass.bsdf.specular_transmittance.value",
    "mirror.bsdf.bsdf_0.reflectance.value",
    "mirror.bsdf.bsdf_1.specular_reflectance.value",
    "coloured.bsdf.bsdf_0.reflectance.value",
    "coloured.bsdf.bsdf_1.specular_reflectance.value",
)
ERRORS = (0.1, 0.03, 0.01, 0.003, 0.001)


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
        scene[f"light{number}"] = {
            "type": "point",
            "position": light["position"],
            "intensity": _rgb([pi * fade * c for c in light["colour"]]),
        }
    for thing in data["object"]:
        scene[thing["name"]] = _shape(thing) | {"material": materials[thing["material"]]}
    return mi.load_dict(scene)


def _rgb(value) -> dict:
    return {"type": "rgb", "value": value}


def _camera(camera: dict, width: int, height: int) -> dict:
    look = mi.ScalarTransform4f().look_at(camera["look_from"], camera["look_at"], camera["up"])
    return {
        "type": "perspective",
        "fov": camera["vfov_deg"],
        "fov_axis": "y",
        "to_world": look,
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "pixel_format": "rgb",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent"},
    }


def _shape(thing: dict) -> dict:
    if thing["type"] == "sphere":
        return {"type": "sphere", "center": thing["centre"], "radius": thing["radius"]}
    far = 1000.0
    place = mi.ScalarTransform4f().translate([0, thing["offset"], 0]).rotate([1, 0, 0], -90).scale(far)
    return {"type": "rectangle", "to_world": place}


def _material(material: dict, textures: dict) -> dict:
    if material.get("k_t"):
        return {
            "type": "dielectric",
            "int_ior": material["refractive_index"],
            "ext_ior": 1.0,
            "specular_reflectance": _rgb(1.0),
            "specular_transmittance": _rgb(material["k_t"]),
        }
    colour = _rgb(material["k_d"]) if "k_d_texture" not in material else _checker(textures[material["k_d_texture"]])
    if not material.get("k_s"):
        return {"type": "diffuse", "reflectance": colour}
    # A blend with a fixed weight, so that k_d and k_s are coefficients of their own.
    weight = (1 + material["k_s"] - max(material["k_d"])) / 2
    diffuse = {"type": "diffuse", "reflectance": _rgb([k / (1 - weight) for k in material["k_d"]])}
    mirror = {"type": "conductor", "material": "none", "specular_reflectance": _rgb(material["k_s"] / weight)}
    return {"type": "blendbsdf", "weight": weight, "diffuse": diffuse, "mirror": mirror}


def _checker(texture: dict) -> dict:
    # A texture's period is two cells; the rectangle spans 2000 m.
    even, odd = map(_rgb, texture["colours"])
    return {
        "type": "checkerboard",
        "color0": odd,
        "color1": even,
        "to_uv": mi.ScalarTransform3f().scale(1000 / texture["size"]),
    }


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


def fit(variant: str) -> dict:
    """Adam on the 18 numbers of `FITTED` (linear RGB each) from 0.5, on a target of many samples.

    The derivative is that of the `path` integrator: the one made for inverse problems, `prb`, gives zero for perfect
    mirrors and glass.
    """
    scene = scene_of(*FIT_SIZE)
    params = mi.traverse(scene)
    params.keep(list(FITTED))
    truth = {key: np.array(params[key]).ravel() for key in FITTED}
    target = mi.render(scene, spp=REFERENCE_SAMPLES, seed=10**6)
    dr.eval(target)
    begun = time.perf_counter()
    adam = mi.ad.Adam(lr=0.03)
    for key in FITTED:
        adam[key] = mi.Color3f(0.5)
    params.update(adam)
    reached, step, seconds, worst = {}, 0, 0.0, 1.0
    while seconds < FIT_SECONDS and worst > ERRORS[-1]:
        loss = dr.mean(dr.square(mi.render(scene, params, spp=FIT_SAMPLES, seed=step) - target))
        dr.backward(loss)
        adam.step()
        adam.set_learning_rate(0.03 * 0.5 ** (step / 400))
        for key in FITTED:
            adam[key] = dr.clip(adam[key], 0, 1)
        params.update(adam)
        step, seconds = step + 1, time.perf_counter() - begun
        worst = max(float(np.abs(np.array(params[key]).ravel() - truth[key]).max()) for key in FITTED)
        for error in ERRORS:
            if worst <= error:
                reached.setdefault(str(error), seconds)
    return {"reached": reached, "steps": step, "seconds": seconds, "worst": worst, "unknowns": 3 * len(FITTED)}


if __name__ == "__main__":
    chosen = choose_variant()
    found = {"render": render, "fit": fit}[sys.argv[1]](chosen)
    print(json.dumps({"version": mi.__version__, "variant": chosen} | found))
