"""A scene out of the YAML of "The Ray Tracer Challenge": `- add: camera`, `light`, a shape, and `- define:`.

Its axes are left-handed, so z is turned round. Light is Whitted's, with the highlight of the reflected ray; ambient
light is that of all lights together.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...scene import Camera, PointLight, Precision, Scene
from ..others._found import Found
from ._materials import Materials
from ._nodes import Entry, read_nodes
from ._shapes import KNOWN_KEYS, SHAPES
from ._transforms import transform_of

FLIP = np.diag([1.0, 1.0, -1.0, 1.0])
DEEPEST = 32
BOUNCES = 5
"""The book's rays turn so often."""
SOLID_SETS = {"union", "intersection", "difference", "csg"}


def parse_challenge(data: bytes, source: str, precision: Precision) -> Scene:
    """The scene in the bytes of a file. Raises `SceneError` that names the line; a `SceneNote` says what is lost."""
    return _Reading(source).scene(read_nodes(data, source), precision)


@dataclass(frozen=True, eq=False)
class _Above:
    """What a group hands down."""

    matrix: np.ndarray
    material: Entry | None = None
    depth: int = 0


class _Reading:
    """What has been read so far."""

    def __init__(self, source: str):
        self._found = Found(source, "The Ray Tracer Challenge")
        self._defined: dict[str, Entry] = {}
        self._extends: dict[str, str] = {}
        self._materials = Materials(self._found, self._defined, self._extends)
        self._strength = np.zeros(3)
        self._steps = 0

    def scene(self, whole: Entry, precision: Precision) -> Scene:
        """The scene of all entries."""
        for entry in whole.entries("the file"):
            keys = entry.table("an entry")
            if "define" in keys:
                self._define(entry, keys)
            elif "add" in keys:
                self._add(entry, keys, _Above(FLIP))
            else:
                raise entry.error(f"an entry with the keys {', '.join(keys)[:80]}; allowed is one with add or define")
        self._materials.tell()
        return self._found.scene(
            ambient=self._strength,
            max_depth=BOUNCES + 1,
            shadows="opaque",
            total_internal_reflection="whitted",
            precision=precision,
        )

    def _define(self, entry: Entry, keys: dict[str, Entry]) -> None:
        name = keys["define"].word("define")
        if "value" not in keys:
            raise entry.error(f"define {name!r} has no value; allowed are keys, a list, or a shape with add")
        if "extend" in keys:
            base = keys["extend"].word("extend")
            if base not in self._defined:
                raise keys["extend"].error(f"extend: {base!r} is not defined above")
            self._extends[name] = base
            if base == name:
                raise keys["extend"].error(f"{name!r} extends itself; allowed is another name")
        self._defined[name] = keys["value"]

    def _add(self, entry: Entry, keys: dict[str, Entry], above: _Above) -> None:
        """A camera, a light, a shape, or what was defined under a name."""
        kind, self._steps = keys["add"].word("add"), self._steps + 1
        if above.depth > DEEPEST or self._steps > 1_000_000:
            raise entry.error(f"groups within groups more than {DEEPEST} deep, or a million parts; allowed is fewer")
        if kind == "camera":
            return self._camera(entry, keys)
        if kind == "light":
            return self._light(entry, keys)
        # Go on with where it stands and what it wears.
        matrix = above.matrix
        if "transform" in keys:
            matrix = matrix @ transform_of(keys["transform"], self._defined)
        if "transforms" in keys:
            raise keys["transforms"].error("unknown key 'transforms'; allowed is transform")
        below = _Above(matrix, keys.get("material", above.material), above.depth + 1)
        lost = self._found.lost
        if "shadow" in keys and not keys["shadow"].truth("shadow"):
            lost.say("shadow: false of {} is lost: it casts one", ("shape", kind))
        if kind == "group":
            for child in keys["children"].entries("children") if "children" in keys else []:
                self._child(child, below)
        elif kind in SOLID_SETS:
            lost.say("left out: {}", ("set of solids", kind))
        elif kind in SHAPES:
            unknown = [key for key in keys if key not in KNOWN_KEYS]
            if unknown:
                raise keys[unknown[0]].error(f"unknown key {unknown[0][:40]!r} of a {kind}")
            material = self._materials.named(below.material, matrix, kind)
            SHAPES[kind](self._found, entry, keys, matrix, material)
        elif kind in self._defined:
            self._child(self._defined[kind], below)
        else:
            allowed = ", ".join(["camera", "light", "group", *SHAPES])
            raise entry.error(f"add: {kind[:40]!r}; allowed is {allowed}, and what is defined above")

    def _child(self, entry: Entry, above: _Above) -> None:
        keys = entry.table("a shape")
        if "add" not in keys:
            raise entry.error("a shape without add; allowed is `add: sphere` and so on")
        self._add(entry, keys, above)

    def _camera(self, entry: Entry, keys: dict[str, Entry]) -> None:
        """`field-of-view` is that of the longer side, radians."""
        missing = [key for key in ("width", "height", "field-of-view", "from", "to", "up") if key not in keys]
        if missing:
            raise entry.error(f"the camera has no {missing[0]}")
        sides = []
        for key in ("width", "height"):
            side = keys[key].number(key)
            if not (side.is_integer() and 1 <= side <= 32768):
                raise keys[key].error(f"{key} = {side:g}; allowed is a whole number from 1 to 32768")
            sides.append(int(side))
        width, height = sides
        angle = keys["field-of-view"].number("field-of-view")
        if not 0 < angle < np.pi:
            raise keys["field-of-view"].error(f"field-of-view = {angle:g}; allowed is between 0 and pi radians")
        half = np.tan(angle / 2) * min(1.0, height / width)
        eye, at, up = (keys[key].numbers(key) * (1, 1, -1) for key in ("from", "to", "up"))
        name = self._found.named("camera" if self._found.cameras else "main", "camera")
        self._found.cameras[name] = Camera(
            eye, at, float(np.degrees(2 * np.arctan(half))), width, height, up, place=f"{entry.place()}: the camera"
        )

    def _light(self, entry: Entry, keys: dict[str, Entry]) -> None:
        if "intensity" not in keys:
            raise entry.error("the light has no intensity")
        colour = keys["intensity"].numbers("intensity")
        if "corner" in keys:
            corner, *sides = (keys[key].numbers(key) for key in ("corner", "uvec", "vvec") if key in keys)
            where = corner + 0.5 * np.sum(sides, axis=0)
            self._found.lost.say("a light with an area shines from its middle, with sharp shadows")
        elif "at" in keys:
            where = keys["at"].numbers("at")
        else:
            raise entry.error("the light has no place; allowed is at: [x, y, z]")
        self._strength += colour
        light: Any = PointLight(where * (1, 1, -1), colour, place=f"{entry.place()}: the light")
        self._found.add_light(light, entry.place())
