"""Wavefront OBJ with its MTL as a scene, and bare meshes (PLY, STL, OFF): what is there, looked at from in front.

Such files hold no camera and no light; both are put so that all of it is seen and lit, and a note says so. What is made
of materials keeps them; MTL's own model is Whitted's (see `_mtl`).
"""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from .._errors import SceneNote
from ..scene import Camera, DirectionalLight, Material, Mesh, Precision, Scene
from ..shapes import read_parts
from ._format import SceneFormat
from ._losses import Losses

PLAIN = "plain"
ANGLE = 40.0
SIZE = 640, 480
VIEW = np.asarray([0.6, 0.45, 1.0])
"""From the middle of what is there to the camera."""
LAMP = (0.3, 1.0, 0.8)
NEVER_MIRRORS = 2
"""The largest `illum` without a mirror ray."""
GLASS = (4, 6, 7, 9)
"""Those with a transmitted ray."""


def parse_obj(data: bytes, source: str, precision: Precision) -> Scene:
    """The scene in an OBJ file, an object for each of its materials. Raises `SceneError` naming the file."""
    del data
    lost = Losses("OBJ")
    parts = read_parts(source, source, group_material=True, split_object=False)
    objects, materials = [], {}
    for number, part in enumerate(parts, 1):
        name = str(getattr(part.material, "name", None) or PLAIN).replace(".", "_")
        if name not in materials:
            materials[name] = _material(getattr(part.material, "kwargs", None) or {}, name, lost)
            if getattr(part.material, "image", None) is not None:
                lost.say("the picture of {} is lost; state it as [[texture]] in a TOML scene", ("material", name))
        called = f"{name}_{number}" if len(parts) > 1 else name
        objects.append(Mesh(called, part.vertices, part.faces, name, normals=part.normals))
    return _seen(objects, materials, lost, source, precision)


def parse_mesh(data: bytes, source: str, precision: Precision) -> Scene:
    """The mesh in a file as a scene, of grey clay. Raises `SceneError` naming the file."""
    del data
    mesh = Mesh(Path(source).stem.replace(".", "_") or "mesh", material=PLAIN, file=source, place=source)
    lost = Losses(Path(source).suffix[1:].upper())
    return _seen([mesh], {PLAIN: Material(k_a=0.2, k_d=0.7)}, lost, source, precision)


def _material(stated: dict[str, Any], name: str, lost: Losses) -> Material:
    """The coefficients of MTL's keys, which are as the file has them or in small letters."""
    keys = {key.lower(): value for key, value in stated.items()}

    def numbers(key: str, default) -> np.ndarray:
        try:
            return np.clip(np.asarray(keys.get(key, default), float), 0, None)
        except (TypeError, ValueError):
            lost.say(f"{key} of {{}} is no number and is left out", ("material", name))
            return np.asarray(default, float)

    def number(key: str, default: float) -> float:
        return float(np.ravel(numbers(key, default))[0])

    illum, opaque = int(number("illum", 2)), number("d", 1.0)
    if "tr" in keys and "d" not in keys:
        opaque = 1 - number("tr", 0.0)
    shine, exponent = numbers("ks", (0.0,) * 3), number("ns", 10.0)
    coefficients: dict[str, Any] = {"k_a": numbers("ka", (0.0,) * 3), "k_d": numbers("kd", (0.8,) * 3)}
    coefficients |= {"k_h": shine if illum > 1 else 0.0, "phong_exponent": max(exponent, 0.01)}
    coefficients["k_s"] = shine if illum > NEVER_MIRRORS else 0.0
    if illum in GLASS or opaque < 1:
        through = numbers("tf", (1 - opaque if opaque < 1 else 1.0,) * 3)
        coefficients |= {"k_t": through, "refractive_index": max(number("ni", 1.0), 1.0)}
    return Material(**coefficients)


def _seen(objects: list[Mesh], materials: dict[str, Material], lost: Losses, source: str, precision) -> Scene:
    """The scene with a camera from which all of it is seen, and a light."""
    corners = np.concatenate([np.asarray(thing.vertices, np.float64) for thing in objects])
    middle, size = 0.5 * (corners.min(axis=0) + corners.max(axis=0)), np.ptp(corners, axis=0)
    away = 0.55 * float(np.linalg.norm(size)) / np.sin(np.radians(ANGLE / 2))
    eye = middle + VIEW / np.linalg.norm(VIEW) * (away or 1.0)
    lost.say(
        f"the file holds no camera and no light: a camera at {np.round(eye, 3).tolist()} looks at all of it, and one "
        "light shines from above; convert it to TOML to set others"
    )
    for sentence in lost:
        warnings.warn(f"{source}: {sentence}", SceneNote, stacklevel=4)
    return Scene(
        objects=objects,
        materials=materials,
        lights=[DirectionalLight(LAMP, (1.0, 1.0, 1.0), name="above")],
        cameras={"main": Camera(eye, middle, ANGLE, *SIZE)},
        precision=precision,
    )


OBJ = SceneFormat("OBJ", (".obj",), parse=parse_obj)
BARE = SceneFormat("a mesh", (".ply", ".stl", ".off"), parse=parse_mesh)
