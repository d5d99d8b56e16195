"""A scene out of XML of Mitsuba 3: the reverse of the writer, and what people write by hand."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...scene import Camera, ConstantBackground, DirectionalLight, OrthographicCamera, PointLight, Precision, Scene
from ..others._found import Found
from ..others._placed import at, linear, shift
from ._read_materials import Bsdfs
from ._read_shapes import SHAPES, lamp_of
from ._tags import Tag, read_tags
from ._values import shade, to_world

USUAL_DEPTH = 8
"""Of an integrator without an end."""
LARGEST_DEPTH = 64
FILM = 768, 576
SILENT = {"integrator", "sampler", "texture", "bsdf", "default"}


def parse_mitsuba(data: bytes, source: str, precision: Precision) -> Scene:
    """The scene in the bytes of a file. Raises `SceneError` that names the line; a `SceneNote` says what is lost."""
    root, found = read_tags(data, source), Found(source, "Mitsuba")
    bsdfs, background = Bsdfs(root, found), None
    depth = _depth(root, found)
    for tag in root.children:
        if tag.word == "sensor":
            _add_camera(tag, found)
        elif tag.word == "emitter":
            background = _add_emitter(tag, found) or background
        elif tag.word == "shape":
            _add_shape(tag, found, bsdfs)
        elif tag.word not in SILENT:
            found.lost.say(f"left out: <{tag.word[:40]}>")
    found.lost.say("ambient light is none: what a path tracer gathers from surfaces is not added")
    return found.scene(
        ambient=(0.0, 0.0, 0.0),
        background=background or ConstantBackground((0.0, 0.0, 0.0)),
        max_depth=depth,
        shadows="tinted",
        precision=precision,
    )


def _depth(root: Tag, found: Found) -> int:
    """Rays here are one fewer than the path's, which counts the one to the light."""
    integrator = next(root.of("integrator"), None)
    stated = -1 if integrator is None else integrator.whole("max_depth", -1, -1, 10**9)
    if stated < 0:
        found.lost.say(f"the integrator has no end: max_depth is {USUAL_DEPTH}")
        return USUAL_DEPTH
    return min(max(stated - 1, 1), LARGEST_DEPTH)


def _add_camera(tag: Tag, found: Found) -> None:
    if tag.type not in CAMERAS:
        found.lost.say(f"left out: a sensor ({tag.type[:40]})")
        return
    film = next(tag.of("film"), Tag("film", {}, tag.place))
    width, height = (film.whole(key, side, 1, 32768) for key, side in zip(("width", "height"), FILM, strict=True))
    crop = None
    if any(film.named(key) for key in ("crop_offset_x", "crop_offset_y", "crop_width", "crop_height")):
        left, top = (film.whole(f"crop_offset_{axis}", 0, 0, 32768) for axis in "xy")
        across, down = film.whole("crop_width", width, 1, 32768), film.whole("crop_height", height, 1, 32768)
        crop = (left, top, across, down)
    name = found.named(tag.attributes.get("id") or ("camera" if found.cameras else "main"), "camera")
    if "near_clip" in {child.name for child in tag.children}:
        found.lost.say("near_clip of {} is lost: what is nearer is seen too", ("camera", name))
    matrix = to_world(tag)
    if np.linalg.det(linear(matrix)) < 0:
        found.lost.say("the view of {} is mirrored in the file; here left is right", ("camera", name))
    found.cameras[name] = CAMERAS[tag.type](tag, matrix, width, height, crop, name, found)


def _perspective(tag: Tag, matrix: np.ndarray, width: int, height: int, crop, name: str, found: Found) -> Camera:
    if tag.type == "thinlens":
        found.lost.say("the lens of {} is lost: all is sharp", ("camera", name))
    aspect = width / height
    axis = tag.text("fov_axis", "x")
    axis = {"smaller": "y" if aspect >= 1 else "x", "larger": "x" if aspect >= 1 else "y"}.get(axis, axis)
    if tag.named("focal_length", "string"):
        millimetres = Tag("string", {"value": tag.text("focal_length", "50mm").removesuffix("mm")}, tag.place)
        half, axis = np.hypot(36, 24) / 2 / millimetres.numbers("value", 1)[0], "diagonal"
    else:
        angle = tag.number("fov", 50.0)
        if not 0 < angle < 180:
            raise tag.error(f"fov = {angle:g}; allowed is between 0 and 180 degrees")
        half = np.tan(np.radians(angle) / 2)
    if axis not in ("x", "y", "diagonal"):
        raise tag.error(f"fov_axis = {axis[:20]!r}; allowed is x, y, diagonal, smaller or larger")
    half = half / {"x": aspect, "y": 1.0, "diagonal": float(np.hypot(aspect, 1))}[axis]
    offset = np.asarray([tag.number(f"principal_point_offset_{axis}", 0.0) for axis in "xy"])
    middle = None
    if offset.any():
        middle = (0.5 - offset) * (width, height)
    eye, ahead, up = _view(matrix)
    return Camera(
        eye, ahead, float(np.degrees(2 * np.arctan(half))), width, height, up, principal_point=middle, crop=crop,
        place=tag.place,
    )  # fmt: skip


def _orthographic(
    tag: Tag, matrix: np.ndarray, width: int, height: int, crop, name: str, found: Found
) -> OrthographicCamera:
    """Without a scale the picture is 2 wide."""
    across, down = np.linalg.norm(linear(matrix)[:, :2], axis=0)
    if abs(across - down) > 1e-6 * across:
        found.lost.say("{} is not square: its height is that of its width", ("camera", name))
    eye, ahead, up = _view(matrix)
    return OrthographicCamera(
        eye, ahead, float(2 * across * height / width), width, height, up=up, crop=crop, place=tag.place
    )


def _view(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where a camera is, looks at, and what is up."""
    ahead = linear(matrix)[:, 2] / np.linalg.norm(linear(matrix)[:, 2])
    return shift(matrix), shift(matrix) + ahead, linear(matrix)[:, 1]


CAMERAS: dict[str, Callable] = {"perspective": _perspective, "thinlens": _perspective, "orthographic": _orthographic}


def _add_emitter(tag: Tag, found: Found) -> ConstantBackground | None:
    """A light; what arrives of pi is the colour 1, as diffuse surfaces send back a pi-th of what they get."""
    name = found.named(tag.attributes.get("id"), "light")
    matrix, lost = to_world(tag), found.lost
    if tag.type == "constant":
        lost.say("a constant emitter is seen, and lights nothing")
        return ConstantBackground(shade(tag.named("radiance"), 1.0, lost))
    if tag.type in ("point", "spot"):
        if tag.type == "spot":
            lost.say("the cone of {} is lost: it shines to all sides", ("light", name))
        stated = tag.named("position")
        where = at(matrix, np.zeros(3) if stated is None else stated.point())
        colour = shade(tag.named("intensity"), 1.0, lost) / np.pi
        made = PointLight(where, colour, (0, 0, 1), name, tag.place, "none")
    elif tag.type == "directional":
        stated = tag.named("direction")
        shines = linear(matrix) @ ((0, 0, 1) if stated is None else stated.point())
        made = DirectionalLight(-shines, shade(tag.named("irradiance"), 1.0, lost) / np.pi, name, tag.place)
    else:
        lost.say(f"left out: {{}} ({tag.type[:40]})", ("light", name))
        return None
    found.add_light(made, tag.place)
    return None


def _add_shape(tag: Tag, found: Found, bsdfs: Bsdfs) -> None:
    name = tag.attributes.get("id")
    light = next(tag.of("emitter"), None)
    if tag.type not in SHAPES:
        found.lost.say("left out: {}", ("shape", f"{name or 'shape'} ({tag.type[:40]})"))
        return
    matrix = to_world(tag)
    if light is not None:
        made = lamp_of(tag, matrix, shade(light.named("radiance"), 1.0, found.lost), found.named(name, "light"))
        if made is not None:
            found.lost.say("left out: {}, in place of whose area a point shines", ("shape", made.name or ""))
            return found.add_light(made, tag.place)
        found.lost.say("the light that {} sends out is lost", ("shape", name or tag.type))
    SHAPES[tag.type](tag, matrix, name, found, bsdfs, Path(found.source).parent)
