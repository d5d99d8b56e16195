"""A whole scene as XML of Mitsuba 3, with the triangles of flat shapes in files beside it."""

import os
from pathlib import Path
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import numpy as np

from ..._errors import printable
from ...scene import (
    Checker,
    ConstantBackground,
    DirectionalLight,
    EnvironmentBackground,
    GradientBackground,
    HarmonicBackground,
    Plane,
    PointLight,
    Scene,
    Sphere,
    SpotLight,
)
from .._format import Written
from .._losses import Losses, named
from .._meshes import MESHES, checker_coordinates, polygon_file
from .._numbers import extent, fading, plain, rgb
from .._panoramas import ENDING, exr_file, panorama
from .._words import words_of
from ._cameras import add_cameras
from ._materials import add_material
from ._words import colour, number, placed, point, whole, word

SAID = ("ambient", "max_depth", "cutoff", "shadows", "total_internal_reflection")


def mitsuba_scene(scene: Scene, source: str) -> Written:
    """The scene with the nearest that a path tracer has of each thing."""
    lost = Losses("Mitsuba")
    lost.unknown_settings(scene, SAID)
    lit = ", also in highlights and with shadows" if scene.background.lights_surfaces else ", as it does not here"
    lost.say(f"ambient light is lost; surfaces light each other and the background lights them{lit}")
    root = Element("scene", version="3.0.0")
    integrator = SubElement(root, "integrator", type="path")
    whole(integrator, "max_depth", scene.max_depth + 1)
    add_cameras(root, scene, lost)
    stem = Path(os.path.realpath(source)).stem
    sky = _add_background(root, scene, stem, lost)
    for light in scene.lights:
        _add_light(root, scene, light, lost)
    beside = sky | _add_things(root, scene, stem, lost)
    # Say first what the file does not hold.
    for place, sentence in enumerate(lost.here()):
        root.insert(place, Comment(f" Not in this file: {sentence.replace('--', '- -')} "))
    indent(root)
    return Written(tostring(root, encoding="utf-8", xml_declaration=True) + b"\n", tuple(lost), beside)


def _add_background(root: Element, scene: Scene, stem: str, lost: Losses) -> dict[str, bytes]:
    """What surrounds the scene; returns the file of a map."""
    match scene.background:
        case EnvironmentBackground() | HarmonicBackground():
            return _add_map(root, scene.background, stem, lost)
        case ConstantBackground(colour=shade):
            radiance = rgb(shade)
        case GradientBackground(bottom=bottom, top=top):
            radiance = (rgb(bottom) + rgb(top)) / 2
            lost.say("the gradient of the background is its mean colour")
        case other:
            lost.say(f"the background ({other.written_type()}) is left out: it is black in the file")
            return {}
    if radiance.any():
        colour(SubElement(root, "emitter", type="constant"), "radiance", radiance)
    return {}


def _add_map(root: Element, background, stem: str, lost: Losses) -> dict[str, bytes]:
    """A map of all that is far away. Mitsuba's has its left edge where ours has the middle."""
    texels, turned_deg = panorama(background, lost)
    emitter = SubElement(root, "emitter", type="envmap")
    word(emitter, "filename", f"{stem}{ENDING}")
    turn = np.radians(180 - turned_deg)
    across, back = (np.cos(turn), 0, -np.sin(turn)), (np.sin(turn), 0, np.cos(turn))
    placed(emitter, np.asarray([across, (0, 1, 0), back, (0, 0, 0)]))
    lost.say(f"the map of the background is in {stem}{ENDING} beside it")
    return {ENDING: exr_file(texels)}


def _add_light(root: Element, scene: Scene, light, lost: Losses) -> None:
    """A light of colour c is pi c where it arrives, as diffuse surfaces send back a pi-th of what they get."""
    what = ("light", light.name or "")
    if not isinstance(light, (PointLight, DirectionalLight, SpotLight)) or _is_wide(light):
        lost.say(f"left out: {{}} ({light.written_type()})", what)
        return
    lost.unknown(light, [row.name for row in light.ROWS], what)
    arriving = np.pi * rgb(light.colour)
    if isinstance(light, (PointLight, SpotLight)):
        distance = float(np.linalg.norm(plain(light.position) - extent(scene)[0]))
        lost.say("as bright as here in the middle of the scene, and fading by the square of the distance: {}", what)
        emitter = (
            _spot(root, light, lost) if isinstance(light, SpotLight) else SubElement(root, "emitter", type="point")
        )
        if isinstance(light, PointLight):
            point(emitter, "position", plain(light.position))
        colour(emitter, "intensity", arriving * fading(light, distance) * distance**2)
    else:
        emitter = SubElement(root, "emitter", type="directional")
        point(emitter, "direction", -plain(light.direction), "vector")
        colour(emitter, "irradiance", arriving)


def _is_wide(light) -> bool:
    """Is it a spotlight without a cone, or with one that Mitsuba has no word for?"""
    return isinstance(light, SpotLight) and (light.cone_deg is None or float(plain(light.cone_deg)) >= 90)


def _spot(root: Element, light: SpotLight, lost: Losses) -> Element:
    """A cone, in which Mitsuba falls off evenly in the angle."""
    what = ("light", light.name or "")
    outer = float(plain(light.cone_deg))
    inner = outer if light.inner_cone_deg is None else float(plain(light.inner_cone_deg))
    if light.exponent is not None:
        lost.say("exponent of {} is lost", what)
    if inner < outer:
        lost.say("the light of {} falls off evenly in the angle", what)
    axis = light.axis()
    ahead = np.asarray([float(part) for part in (axis.x, axis.y, axis.z)])
    right = np.cross(np.eye(3)[abs(ahead).argmin()], ahead)
    right /= np.linalg.norm(right)
    emitter = SubElement(root, "emitter", type="spot")
    number(emitter, "cutoff_angle", outer)
    number(emitter, "beam_width", inner)
    placed(emitter, np.stack([right, np.cross(ahead, right), ahead, plain(light.position)]))
    return emitter


def _add_things(root: Element, scene: Scene, stem: str, lost: Losses) -> dict[str, bytes]:
    """Materials and objects; returns the files of triangles."""
    size, beside, boards = extent(scene), {}, {}
    materials = words_of(scene.materials, "material_")
    files = words_of([thing.name for thing in scene.objects], f"{stem}_", longest=len(stem) + 40)
    for name in scene.materials:
        mine = [thing for thing in scene.placed_objects() if thing.material == name and type(thing) in MESHES]
        checker = _checker_of(scene, name, mine)
        solid = all(thing.solid for thing in mine)
        add_material(root, scene, name, materials[name], checker is not None, solid, lost)
        boards[name] = checker
    for thing in scene.placed_objects():
        what = ("object", thing.name)
        if type(thing) not in MESHES:
            lost.say(f"left out: {{}} ({thing.written_type()})", what)
            continue
        lost.unknown(thing, [row.name for row in thing.ROWS], what)
        root.append(Comment(f" {printable(named(thing.name)).replace('--', '- -')} "))
        points, normals, triangles = MESHES[type(thing)](thing, *size)
        board = boards[thing.material]
        if isinstance(thing, Sphere):
            shape = SubElement(root, "shape", type="sphere")
            point(shape, "center", plain(thing.centre))
            number(shape, "radius", float(plain(thing.radius)))
        elif isinstance(thing, Plane) and board is None:
            shape = SubElement(root, "shape", type="rectangle")
            middle = points.mean(axis=0)
            placed(shape, np.stack([(points[1] - points[0]) / 2, (points[3] - points[0]) / 2, normals[0], middle]))
        else:
            coordinates = None if board is None else checker_coordinates(board, points)
            shape = SubElement(root, "shape", type="ply")
            ending = files[thing.name].removeprefix(stem) + ".ply"
            word(shape, "filename", f"{stem}{ending}")
            beside[ending] = polygon_file(points, normals, triangles, coordinates)
        if isinstance(thing, Plane):
            lost.say("written as a square: {}", what)
        SubElement(shape, "ref", id=materials[thing.material], name="bsdf")
    if beside:
        lost.say(f"triangles are in files beside it: {', '.join(f'{stem}{ending}' for ending in beside)}")
    return beside


def _checker_of(scene: Scene, name: str, things: list) -> Checker | None:
    """The checkerboard of k_d, where all that wears it is flat and can be given coordinates for it."""
    checker = scene.textures.get(dict(scene.materials[name].textures).get("k_d", ""))
    if not isinstance(checker, Checker) or any(isinstance(thing, Sphere) for thing in things):
        return None
    points = (MESHES[type(thing)](thing, *extent(scene))[0] for thing in things)
    return checker if all(checker_coordinates(checker, some) is not None for some in points) else None
