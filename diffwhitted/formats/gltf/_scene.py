"""A whole scene as one glTF 2.0 file: meshes, materials, cameras, lights."""

import json
from typing import Any

import numpy as np

from ...scene import Camera, DirectionalLight, OrthographicCamera, PointLight, Scene, Sphere
from .._format import Written
from .._losses import Losses, Thing
from .._meshes import MESHES, WIDE, frame
from .._numbers import extent, fading, plain, rgb
from .._rounds import ball
from .._views import aside, axes_of, box, frustum, views_of
from ._buffer import Buffer
from ._materials import material_of
from ._textures import Textures

NEAR = 1e-3
"""The near plane of cameras, in sizes of the scene."""
SAID = ("ambient", "max_depth", "cutoff", "shadows", "total_internal_reflection")


def gltf_scene(scene: Scene, source: str) -> Written:
    """The scene, with spheres and planes as triangles."""
    del source
    lost, buffer, textures = Losses("glTF"), Buffer(), Textures()
    lost.unknown_settings(scene, SAID)
    lost.say("ambient light and background are lost, and how shadows and mirrors are traced is up to the viewer")
    materials = []
    for name, material in scene.materials.items():
        mine = [thing for thing in scene.placed_objects() if thing.material == name and type(thing) in MESHES]
        made, base = material_of(name, material, all(thing.solid for thing in mine), lost)
        textures.dress(made["pbrMetallicRoughness"], base, scene, name, [_points(scene, thing) for thing in mine], lost)
        materials.append(made)
    meshes, nodes = _meshes(scene, buffer, textures, lost)
    cameras = _cameras(scene, nodes, lost)
    lights = _lights(scene, nodes, lost)
    used = {name for material in materials for name in material.get("extensions", {})}
    lists = {
        "extensionsUsed": sorted(used | ({"KHR_lights_punctual"} if lights else set())),
        "extensions": {"KHR_lights_punctual": {"lights": lights}} if lights else {},
        "nodes": nodes, "meshes": meshes, "materials": materials, "cameras": cameras, **textures.lists(),
        "bufferViews": buffer.views, "accessors": buffer.accessors, "buffers": [buffer.written()] if meshes else [],
    }  # fmt: skip
    content = {
        "asset": {"version": "2.0", "generator": "diffwhitted", "extras": {"not_in_this_file": lost.here()}},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))} if nodes else {}],
        **{key: value for key, value in lists.items() if value},
    }
    return Written(
        (json.dumps(content, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8", "backslashreplace"),
        tuple(lost),
    )


def _points(scene: Scene, thing) -> np.ndarray:
    return MESHES[type(thing)](thing, *extent(scene))[0]


def _meshes(scene: Scene, buffer: Buffer, textures: Textures, lost: Losses):
    """A mesh and a node for each object; all spheres share the points of one."""
    meshes, nodes, shared = [], [], None
    numbers = {name: number for number, name in enumerate(scene.materials)}
    size = extent(scene)
    for thing in scene.placed_objects():
        if type(thing) not in MESHES:
            lost.say(f"left out: {{}} ({thing.written_type()})", ("object", thing.name))
            continue
        lost.unknown(thing, [row.name for row in thing.ROWS], ("object", thing.name))
        points, normals, triangles = MESHES[type(thing)](thing, *size)
        node: dict[str, Any] = {"name": thing.name, "mesh": len(meshes)}
        if isinstance(thing, Sphere):
            shared = shared or _primitive(buffer, *ball())
            attributes, indices = shared
            node |= {"translation": plain(thing.centre).tolist(), "scale": [float(plain(thing.radius))] * 3}
        else:
            attributes, indices = _primitive(buffer, points, normals, triangles)
        coordinates = textures.coordinates(thing.material, points)
        if coordinates is not None:
            attributes = {**attributes, "TEXCOORD_0": buffer.vectors(coordinates)}
        primitive = {"attributes": attributes, "indices": indices, "material": numbers[thing.material]}
        meshes.append({"name": thing.name, "primitives": [primitive]})
        nodes.append(node)
        if thing.written_type() == "plane":
            lost.say("written as a square: {}", ("object", thing.name))
    return meshes, nodes


def _primitive(buffer: Buffer, points, normals, triangles) -> tuple[dict[str, int], int]:
    attributes = {"POSITION": buffer.vectors(points, with_bounds=True), "NORMAL": buffer.vectors(normals)}
    return attributes, buffer.numbers(triangles)


def _cameras(scene: Scene, nodes: list, lost: Losses) -> list[dict[str, Any]]:
    cameras = []
    for name, view in views_of(scene, (Camera, OrthographicCamera), lost).items():
        position = plain(view.look_from)
        if isinstance(view, OrthographicCamera):
            position = position + aside(view)
            lens = _orthographic(view, scene)
        elif isinstance(view, Camera):
            lens = _perspective(view, scene, ("camera", name), lost)
        nodes.append({"name": name, "camera": len(cameras), "matrix": _matrix(axes_of(view), position)})
        cameras.append({"name": name, **lens})
    return cameras


def _perspective(view: Camera, scene: Scene, what: Thing, lost: Losses) -> dict[str, Any]:
    """The window where straight ahead is its middle; else the full picture as if that were so."""
    window = frustum(view)
    if not window.is_centred:
        window = frustum(view, whole=True)
        if view.crop is not None:
            lost.say("crop of {} is lost: the full picture is seen", what)
        if not window.is_centred:
            lost.say("principal_point of {} is lost: look_at is in the middle of the picture", what)
    across, down = window.size
    perspective = {
        "yfov": 2 * float(np.arctan(down / 2)),
        "aspectRatio": float(across / down),
        "znear": NEAR * extent(scene)[1],
    }
    return {"type": "perspective", "perspective": perspective}


def _orthographic(view: OrthographicCamera, scene: Scene) -> dict[str, Any]:
    across, down = box(view).size.tolist()
    middle, size = extent(scene)
    far = float(np.linalg.norm(middle - plain(view.look_from))) + 2 * WIDE * size
    return {"type": "orthographic", "orthographic": {"xmag": across / 2, "ymag": down / 2, "znear": 0.0, "zfar": far}}


def _lights(scene: Scene, nodes: list, lost: Losses) -> list[dict[str, Any]]:
    """A light of colour c is pi c lux where it arrives, as diffuse surfaces send back a pi-th of what they get."""
    lights, middle = [], extent(scene)[0]
    for light in scene.lights:
        what, name = ("light", light.name or ""), light.name or ""
        if not isinstance(light, (PointLight, DirectionalLight)):
            lost.say(f"left out: {{}} ({light.written_type()})", what)
            continue
        lost.unknown(light, [row.name for row in light.ROWS], what)
        shade = rgb(light.colour)
        strength = float(shade.max())
        hue = (shade / strength).tolist() if strength else [0.0, 0.0, 0.0]
        node = {"name": name, "extensions": {"KHR_lights_punctual": {"light": len(lights)}}}
        if isinstance(light, PointLight):
            distance = float(np.linalg.norm(plain(light.position) - middle))
            arriving = strength * fading(light, distance)
            lights.append({"name": name, "type": "point", "color": hue, "intensity": np.pi * arriving * distance**2})
            nodes.append(node | {"translation": plain(light.position).tolist()})
            lost.say("as bright as here in the middle of the scene, and fading by the square of the distance: {}", what)
        else:
            lights.append({"name": name, "type": "directional", "color": hue, "intensity": np.pi * strength})
            back = plain(light.direction) / np.linalg.norm(plain(light.direction))
            across, up = frame(back)
            nodes.append(node | {"matrix": _matrix(np.stack([across, up, back]), np.zeros(3))})
    return lights


def _matrix(axes: np.ndarray, position: np.ndarray) -> list[float]:
    """Column by column: right, up, back, place."""
    return [float(x) for axis in (*axes, position) for x in (*axis, 0.0)][:-1] + [1.0]
