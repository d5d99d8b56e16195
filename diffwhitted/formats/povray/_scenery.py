"""Cameras and lights in POV-Ray's words, as they are read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...scene import Camera, DirectionalLight, OrthographicCamera, PointLight
from .._losses import Losses
from ..others._found import Found
from ..others._placed import at, linear
from ._expressions import Expressions
from ._stream import Stream
from ._tokens import SIZE, Token

HEIGHT = 480
"""Rows of the picture, where no comment says +W and +H."""
SQUARE = 1e-9
"""Part by which the sides of a pixel may differ."""


@dataclass(eq=False)
class View:
    """A camera in POV-Ray's own axes: a ray is ahead + u right + v up, u and v from -1/2 to 1/2."""

    token: Token
    place: np.ndarray
    ahead: np.ndarray
    right: np.ndarray
    up: np.ndarray
    parallel: bool
    spot: tuple[str, int]


def is_right_handed(views: Sequence[View]) -> bool:
    """Has the file turned the axes of the first camera round?"""
    if not views:
        return False
    first = views[0]
    return bool(np.linalg.det(np.stack([first.right, first.up, first.ahead])) < 0)


class Views:
    """Reads the cameras."""

    def __init__(self, stream: Stream, expressions: Expressions, lost: Losses):
        self._stream, self._read, self._lost = stream, expressions, lost
        self.found: list[View] = []

    def declare_size(self, data: bytes) -> None:
        """Let image_width and image_height be what the first comment with +W and +H says, or of 4:3."""
        stated = SIZE.search(data.decode("latin-1"))
        width, height = (int(stated[1]), int(stated[2])) if stated else (HEIGHT * 4 // 3, HEIGHT)
        self._stream.values |= {"image_width": float(width), "image_height": float(height)}

    def add(self, token: Token, further: bool = False) -> None:
        """After the word `camera`. `further`: of a case that is not taken."""
        if self.found and not further:
            self._lost.say("a camera below another takes its place in POV-Ray; here both are there")
        stream, read = self._stream, self._read
        stated: dict[str, np.ndarray] = {
            "location": np.zeros(3), "direction": np.asarray([0, 0, 1.0]), "up": np.asarray([0, 1.0, 0]),
            "right": np.asarray([4 / 3, 0, 0]), "sky": np.asarray([0, 1.0, 0]),
        }  # fmt: skip
        angle, parallel, matrix = None, False, np.eye(4)
        for word in stream.block(token):
            step = read.transform(word)
            if step is not None:
                matrix = step @ matrix
            elif word.text in (*stated, "look_at"):
                stated[word.text] = read.vector(word.text)
            elif word.text == "angle":
                angle = read.number("angle")
            elif word.text in ("perspective", "orthographic"):
                parallel = word.text == "orthographic"
            elif word.text in ("aperture", "blur_samples", "focal_point", "confidence", "variance", "normal"):
                self._lost.say(f"{word.text} of the camera is lost: all is sharp")
                if stream.peek().text == "{":
                    stream.skip_block(word)
                else:
                    read.expression()
                    if stream.accept(","):
                        read.expression()
            elif word.text != ",":
                raise word.error(
                    f"{word.said()} in a camera; allowed are perspective, orthographic, location, look_at, direction, "
                    "right, up, sky, angle and transforms"
                )
        if parallel and angle is not None:
            self._lost.say("angle of an orthographic camera is lost: right and up say what it sees")
        self.found.append(_aimed(token, stated, angle, parallel, matrix, stream.spot()))

    def make(self, found: Found, flip: np.ndarray) -> None:
        """The cameras in our axes."""
        remarks = self._stream.remarks
        first = next(iter(remarks.sizes.values()), None)
        for view in self.found:
            named = remarks.names.get(view.spot) or ("camera" if found.cameras else "main")
            name = found.named(named, "camera")
            size = remarks.sizes.get(view.spot, first)
            found.cameras[name] = _camera(view, flip, size, self._lost, name)


def _aimed(token: Token, stated, angle: float | None, parallel: bool, matrix: np.ndarray, spot) -> View:
    """With direction, right and up turned to where it looks."""
    place, ahead, right, up = (stated[key] for key in ("location", "direction", "right", "up"))
    if angle is not None:
        if not 0 < angle < (360 if parallel else 180):
            raise token.error(f"angle {angle:g} of the camera; allowed is between 0 and 180 degrees")
        if not parallel:
            length = 0.5 * np.linalg.norm(right) / np.tan(np.radians(angle) / 2)
            ahead = ahead / (np.linalg.norm(ahead) or 1.0) * length
    if "look_at" in stated:
        towards = stated["look_at"] - place
        aside = np.cross(stated["sky"], towards)
        if not (np.linalg.norm(towards) > 0 and np.linalg.norm(aside) > 0):
            raise token.error("a camera that looks at its own place, or along sky; allowed is any other look_at")
        mirrored = np.linalg.det(np.stack([right, up, ahead])) < 0
        towards, aside = towards / np.linalg.norm(towards), aside / np.linalg.norm(aside) * (-1 if mirrored else 1)
        over = np.cross(towards, aside) * (-1 if mirrored else 1)
        ahead = np.linalg.norm(ahead) * towards
        right, up = np.linalg.norm(right) * aside, np.linalg.norm(up) * over
    turned = linear(matrix)
    view = View(token, at(matrix, place), turned @ ahead, turned @ right, turned @ up, parallel, spot)
    sizes = [np.linalg.norm(v) for v in (view.ahead, view.right, view.up)]
    if not min(sizes) > 0 or abs(view.right @ view.up) > 1e-6 * sizes[1] * sizes[2]:
        raise token.error("a camera whose right and up are not square to each other; allowed are two that are")
    return view


def _camera(view: View, flip: np.ndarray, size: tuple[int, int] | None, lost: Losses, name: str):
    turned = linear(flip)
    place, ahead, right, up = (turned @ v for v in (view.place, view.ahead, view.right, view.up))
    across, down = np.linalg.norm(right), np.linalg.norm(up)
    width, height = size or (max(1, round(HEIGHT * across / down)), HEIGHT)
    if size is None:
        lost.say(f"the size of the picture of {{}} is not in the file: {width} x {height}", ("camera", name))
    right, up = right / across, up / down
    normal = np.cross(up, right)
    if normal @ ahead < 0:
        lost.say("the view of {} is mirrored in the file; here left is right", ("camera", name))
        normal = -normal
    pixels = np.asarray([width / across, height / down])
    if view.parallel:
        if abs(pixels[0] / pixels[1] - 1) > 1e-6:
            lost.say("the pixels of {} are not square: its height is that of the file", ("camera", name))
        return OrthographicCamera(place, place + normal, float(down), width, height, up=up, place=view.token.place)
    distance = float(normal @ ahead)
    middle = np.asarray([right @ ahead, up @ ahead])
    lens: dict[str, Any] = {}
    if abs(middle / (across, down)).max() > SQUARE:
        # Where straight ahead is, from the top left corner.
        lens["principal_point"] = np.asarray([width, height]) / 2 - middle * pixels * (1, -1)
    focal = pixels * distance
    if abs(focal[0] / focal[1] - 1) > SQUARE:
        lens["focal"] = focal
    else:
        lens["vfov_deg"] = float(np.degrees(2 * np.arctan(down / 2 / distance)))
    return Camera(place, place + normal, width=width, height=height, up=up, place=view.token.place, **lens)


class Lamps:
    """Reads the lights."""

    def __init__(self, stream: Stream, expressions: Expressions, lost: Losses):
        self._stream, self._read, self._lost = stream, expressions, lost
        self._found: list[tuple[Token, dict[str, Any], tuple[str, int]]] = []

    def add(self, token: Token) -> None:
        """After the word `light_source`."""
        stream, read, lost = self._stream, self._read, self._lost
        stream.expect("{", token.text)
        with stream.deeper(token):
            keys: dict[str, Any] = {"place": read.vector(token.text), "matrix": np.eye(4)}
            stream.comma()
            keys["colour"] = read.colour()[:3]
            stream.comma()
            while not stream.accept("}"):
                word = stream.take()
                step = read.transform(word)
                if step is not None:
                    keys["matrix"] = step @ keys["matrix"]
                elif word.text in ("fade_distance", "fade_power"):
                    keys[word.text] = read.number(word.text)
                elif word.text == "point_at":
                    keys[word.text] = read.vector(word.text)
                elif word.text == "parallel":
                    keys[word.text] = True
                elif word.text in ("spotlight", "cylinder"):
                    lost.say(f"{word.text} is lost: the light shines to all sides")
                elif word.text in ("area_light", "looks_like", "projected_through", "photons", "shadowless"):
                    lost.say(f"{word.text} is lost: the light shines from a point")
                    self._skip(word)
                elif word.text in LAMP_WORDS:
                    self._skip(word)
                else:
                    raise word.error(
                        f"{word.said()} in a light_source; allowed are parallel, point_at, fade_distance, fade_power "
                        "and transforms"
                    )
        self._found.append((token, keys, stream.spot()))

    def _skip(self, word: Token) -> None:
        """Leave out the numbers or the braces after a word."""
        stream = self._stream
        if stream.peek().text == "{":
            return stream.skip_block(word)
        while stream.peek().kind == "number" or stream.peek().text in ("<", "-", "on", "off", "x", "y", "z", ","):
            if not stream.accept(","):
                self._read.expression()

    def make(self, found: Found, flip: np.ndarray) -> None:
        """The lights in our axes."""
        names = self._stream.remarks.names
        for token, keys, spot in self._found:
            matrix = flip @ keys["matrix"]
            where = at(matrix, keys["place"])
            name = found.named(names.get(spot), "light")
            if keys.get("parallel"):
                towards = where - at(matrix, keys.get("point_at", np.zeros(3)))
                made: Any = DirectionalLight(towards, keys["colour"], name, token.place)
            else:
                made = PointLight(where, *_fading(token, keys), name=name, place=token.place)
            found.add_light(made, token.place)


LAMP_WORDS = (
    "radius", "falloff", "tightness", "adaptive", "jitter", "circular", "orient", "area_illumination",
    "media_interaction", "media_attenuation",
)  # fmt: skip


def _fading(token: Token, keys: dict[str, Any]) -> tuple[np.ndarray, Any]:
    """The colour, and a0, a1, a2: what arrives at d is 2 / (1 + (d / fade_distance)^fade_power) of it."""
    power, distance = keys.get("fade_power", 0.0), keys.get("fade_distance", 0.0)
    if power == 0 or distance == 0:
        return keys["colour"], None
    if power not in (1, 2) or distance < 0:
        raise token.error(f"fade_power {power:g}, fade_distance {distance:g}; allowed is 1 or 2, and more than 0")
    part = (0.0, 1 / distance**power)
    return 2 * keys["colour"], (1.0, part[0], part[1]) if power == 2 else (1.0, part[1], part[0])
