"""A scene out of a glTF 2.0 file (.gltf, .glb): meshes where their nodes put them, materials, cameras and lights.

What it says and this program cannot do is named in one note, never dropped in silence.
"""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..._errors import SceneError, SceneNote
from ...records import changed
from ...scene import Camera, DirectionalLight, Material, Mesh, OrthographicCamera, PointLight, Precision, Scene
from .._losses import Losses
from ._arrays import Content
from ._read_materials import Pictures, material_in

HEIGHT = 480
"""Rows of the picture of a camera: glTF states an aspect ratio alone."""
TRIANGLES = 4
PLAIN = "plain"
"""The material of what states none."""


@dataclass
class _Found:
    """What the nodes of a file hold, by name."""

    objects: list[Mesh] = field(default_factory=list)
    cameras: dict[str, Any] = field(default_factory=dict)
    lights: list[Any] = field(default_factory=list)
    names: set[str] = field(default_factory=set)

    def named(self, name, kind: str) -> str:
        """A name of its own, without dots."""
        base = str(name or kind).replace(".", "_") or kind
        chosen, number = base, 2
        while (kind, chosen) in self.names:
            chosen, number = f"{base}_{number}", number + 1
        self.names.add((kind, chosen))  # pyright: ignore[reportArgumentType]
        return chosen


def parse_gltf(data: bytes, source: str, precision: Precision) -> Scene:
    """The scene in the bytes of a file. Raises `SceneError` naming the file and the place in it."""
    content, lost, found = Content(data, source), Losses("glTF"), _Found()
    pictures = Pictures(content, lost)
    # Take the materials by their numbers.
    materials, names = {}, []
    for number, stated in enumerate(content.listed("materials")):
        name = found.named(stated.get("name") or f"material_{number + 1}", "material")
        materials[name] = material_in(content, stated, name, pictures, lost)
        names.append(name)
    # Go down the tree of nodes, with the transform of each.
    scenes = content.listed("scenes")
    roots = content.one("scenes", content.json.get("scene", 0), "scene").get("nodes", []) if scenes else []
    for node, place, where in _nodes(content, roots):
        if "mesh" in node:
            _add_mesh(content, node, place, names, found, lost, where)
        if "camera" in node:
            _add_camera(content, node, place, found, where)
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light is not None:
            _add_light(content, light.get("light"), place, found, lost, where)
        if "skin" in node:
            lost.say("skins are lost: meshes stand as they were modelled")
    if content.json.get("animations"):
        lost.say("animations are lost: the scene stands as at the beginning")
    if any(thing.material == PLAIN for thing in found.objects):
        materials[PLAIN] = Material(k_d=0.8)
    if not found.objects:
        raise SceneError(f"{source}: no node of its scene holds triangles; allowed is a scene of one mesh or more")
    if not found.lights:
        lost.say("the file has no light: ambient light of 1 is all; add lights to see shapes")
    used = {thing.material for thing in found.objects}
    materials = {name: material for name, material in materials.items() if name in used}
    worn = {texture for material in materials.values() for _, texture in material.worn()}
    for sentence in lost:
        warnings.warn(f"{source}: {sentence}", SceneNote, stacklevel=3)
    return Scene(
        objects=found.objects,
        materials=materials if found.lights else {name: _lit(material) for name, material in materials.items()},
        lights=found.lights,
        cameras=found.cameras,
        textures={name: texture for name, texture in pictures.textures.items() if name in worn},
        ambient=(0.0,) * 3 if found.lights else (1.0,) * 3,
        max_depth=8,
        precision=precision,
    )


def _lit(material: Material) -> Material:
    """With k_a in place of k_d, for a scene without a light."""
    worn = dict(material.textures)
    if "k_d" in worn:
        worn["k_a"] = worn["k_d"]
    return changed(material, values=material.values | {"k_a": material.k_d}, textures=tuple(worn.items()))


def _nodes(content: Content, roots) -> Iterator[tuple[dict[str, Any], np.ndarray, str]]:
    """Each node below the roots with its transform (4, 4). Raises `SceneError` for a node that is below itself."""
    ahead = [(number, np.eye(4), ()) for number in reversed(roots)]
    while ahead:
        number, above, path = ahead.pop()
        if number in path:
            raise SceneError(f"{content.source}: nodes[{number}] is its own descendant; allowed is a tree")
        node, where = content.one("nodes", number, "a node"), f"nodes[{number}]"
        place = above @ _transform(node, f"{content.source}: {where}")
        yield node, place, where
        ahead += [(child, place, (*path, number)) for child in reversed(node.get("children", []))]


def _transform(node: dict[str, Any], where: str) -> np.ndarray:
    if "matrix" in node:
        numbers = np.asarray(node["matrix"], float)
        if numbers.shape != (16,) or not np.isfinite(numbers).all():
            raise SceneError(f"{where}: matrix is not 16 finite numbers")
        return numbers.reshape(4, 4).T
    place = np.eye(4)
    x, y, z, w = _numbers(node, "rotation", (0, 0, 0, 1), where)
    size = np.sqrt(x * x + y * y + z * z + w * w) or 1.0
    x, y, z, w = x / size, y / size, z / size, w / size
    turn = np.asarray([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    place[:3, :3] = turn * _numbers(node, "scale", (1, 1, 1), where)
    place[:3, 3] = _numbers(node, "translation", (0, 0, 0), where)
    return place


def _numbers(node: dict[str, Any], key: str, default: tuple, where: str) -> np.ndarray:
    try:
        found = np.asarray(node.get(key, default), float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.shape != (len(default),) or not np.isfinite(found).all():
        raise SceneError(f"{where}: {key} = {node[key]!r} is not {len(default)} finite numbers")
    return found


def _add_mesh(content: Content, node, place, names: list[str], found: _Found, lost: Losses, where: str) -> None:
    mesh = content.one("meshes", node["mesh"], where)
    for primitive in mesh.get("primitives", []):
        name = found.named(node.get("name") or mesh.get("name"), "mesh")
        if primitive.get("mode", TRIANGLES) != TRIANGLES:
            lost.say("points, lines, strips and fans are lost: {}", ("object", name))
            continue
        attributes = primitive.get("attributes", {})
        if "targets" in primitive:
            lost.say("morph targets of {} are lost", ("object", name))
        points = np.asarray(content.array(attributes.get("POSITION"), where), np.float64)
        corners = content.array(primitive["indices"], where) if "indices" in primitive else np.arange(len(points))
        faces = np.asarray(corners, np.int64)[: len(corners) // 3 * 3].reshape(-1, 3)
        normals = content.array(attributes["NORMAL"], where) if "NORMAL" in attributes else None
        uvs = content.array(attributes["TEXCOORD_0"], where) if "TEXCOORD_0" in attributes else None
        linear = place[:3, :3]
        if np.linalg.det(linear) < 0:
            faces = faces[:, ::-1]
        if normals is not None:
            normals = np.asarray(normals, np.float64) @ np.linalg.inv(linear)
            normals = None if (np.linalg.norm(normals, axis=1) == 0).any() else normals
        if uvs is not None:
            uvs = np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1)
        if "COLOR_0" in attributes:
            lost.say("colours of the vertices of {} are lost", ("object", name))
        number = primitive.get("material")
        material = PLAIN if number is None else names[number] if 0 <= number < len(names) else None
        if material is None:
            raise SceneError(f"{content.source}: {where} names materials[{number}], and there are {len(names)}")
        found.objects.append(
            Mesh(
                name,
                points @ linear.T + place[:3, 3],
                faces,
                material,
                normals=normals,
                uvs=uvs,
                shading="flat" if normals is None else "phong",
                place=f"{content.source}: {where}",
            )
        )


def _add_camera(content: Content, node, place, found: _Found, where: str) -> None:
    camera = content.one("cameras", node["camera"], where)
    name = found.named(node.get("name") or camera.get("name") or "main", "camera")
    right, up, back = (place[:3, k] / (np.linalg.norm(place[:3, k]) or 1.0) for k in range(3))
    eye = place[:3, 3]
    if camera.get("type") == "orthographic":
        lens = camera.get("orthographic", {})
        across, down = float(lens.get("xmag", 1.0)), float(lens.get("ymag", 1.0))
        width = max(1, round(HEIGHT * across / down)) if down else HEIGHT
        found.cameras[name] = OrthographicCamera(eye, eye - back, 2 * down, width, HEIGHT, up=up)
        return
    lens = camera.get("perspective", {})
    aspect, angle = float(lens.get("aspectRatio", 4 / 3)), np.degrees(float(lens.get("yfov", 0.8)))
    found.cameras[name] = Camera(eye, eye - back, angle, max(1, round(HEIGHT * aspect)), HEIGHT, up=up)


def _add_light(content: Content, number, place, found: _Found, lost: Losses, where: str) -> None:
    """What arrives of a light of pi lux is the colour 1, as diffuse surfaces send back a pi-th of what they get."""
    lights = content.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    if not isinstance(number, int) or not 0 <= number < len(lights):
        raise SceneError(f"{content.source}: {where} names light {number!r}, and there are {len(lights)}")
    light = lights[number]
    name = found.named(light.get("name") or "light", "light")
    colour = np.asarray(light.get("color", (1, 1, 1)), float) * float(light.get("intensity", 1.0)) / np.pi
    if light.get("type") == "directional":
        found.lights.append(DirectionalLight(place[:3, 2], colour, name=name))
        return
    if light.get("type") == "spot":
        lost.say("the cone of {} is lost: it shines to all sides", ("light", name))
    found.lights.append(PointLight(place[:3, 3], colour, attenuation=(0, 0, 1), clamped=False, name=name))
