"""NFF, the Neutral File Format of E. Haines' databases, read only.

Lines of words: `v` (the view, its parts on lines below), `b` (background), `l` (light), `f` (material of what
follows), `c` (cone or cylinder), `s` (sphere), `p` (polygon), `pp` (polygon with normals at its corners); `#` begins a
comment. From E. Haines, "Standard Procedural Databases" 3.14, NFF text.
"""

import warnings

import numpy as np

from .._errors import SceneNote
from ..scene import Camera, ConstantBackground, Material, PointLight, Precision, Scene
from ..standard import usual_strength, view_angle
from ._format import SceneFormat
from ._nff_things import Fill, Things
from ._nff_words import Line, Words

KINDS = {"v": "the view", "b": "the background", "l": "a light", "f": "a material", "c": "a cone or cylinder",
         "s": "a sphere", "p": "a polygon", "pp": "a polygon with normals"}  # fmt: skip
VIEW = {"from": 3, "at": 3, "up": 3, "angle": 1, "hither": 1, "resolution": 2}
"""The parts of a view, and how many numbers each has."""
MOST_LIGHTS = 1000
"""Each is asked from each point."""


def parse_nff(data: bytes, source: str, precision: Precision) -> Scene:
    """The scene in the bytes of an NFF file.

    A material `f r g b Kd Ks Shine T index` has k_a = k_d = Kd (r, g, b), k_h = k_s = Ks, phong_exponent = Shine,
    k_t = T. Lights without a colour, and the ambient light, are sqrt(L) / (2 L) for L lights. All that has one material
    becomes one set of spheres, one flat mesh of polygons and one smooth mesh of patches; cones and cylinders are open,
    an object each. Raises `SceneError` that names the line; a `SceneNote` says what is left out.
    """
    return _Reading(Words(data, source)).scene(precision)


class _Reading:
    """What has been read so far."""

    def __init__(self, words: Words):
        self._words = words
        self._background = ConstantBackground((0.0, 0.0, 0.0))
        self._camera: Camera | None = None
        self._lights: list[tuple[np.ndarray, np.ndarray | None]] = []
        self._things = Things(words.source)
        self._fill: Fill | None = None
        self._notes: dict[str, int] = {}

    def scene(self, precision: Precision) -> Scene:
        """The scene of all lines."""
        read = {"v": self._view, "b": self._sky, "l": self._light, "f": self._material, "c": self._cone,
                "s": self._sphere, "p": self._polygon, "pp": self._polygon}  # fmt: skip
        for line in self._words.lines():
            if line.word not in read:
                known = ", ".join(f"{word} ({what})" for word, what in KINDS.items())
                raise self._words.error(line, f"a line that begins with {line.said()}; allowed is {known}")
            read[line.word](line)
        objects, materials = self._things.made()
        strength = usual_strength(len(self._lights))
        for note, count in self._notes.items():
            times = f" ({count} times)" if count > 1 else ""
            warnings.warn(f"{self._words.source}: {note}{times}", SceneNote, stacklevel=4)
        return Scene(
            objects=objects,
            materials=materials,
            lights=[
                PointLight(place, np.full(3, strength) if colour is None else colour) for place, colour in self._lights
            ],
            cameras={} if self._camera is None else {"main": self._camera},
            background=self._background,
            ambient=np.full(3, strength),
            max_depth=5,
            shadows="opaque",
            total_internal_reflection="whitted",
            precision=precision,
        )

    def _note(self, line: Line, what: str) -> None:
        """Keep a sentence to be said at the end; the first line of its kind is named."""
        known = next((note for note in self._notes if note.endswith(what)), f"line {line.number}: {what}")
        self._notes[known] = self._notes.get(known, 0) + 1

    def _view(self, line: Line) -> None:
        found = {}
        if self._camera is not None:
            self._note(line, "a second view v takes the place of the first")
        if line.rest:
            raise self._words.error(line, "v stands alone on its line; from, at, up, ... follow on lines of their own")
        for part in self._words.parts(VIEW, line):
            if part.word in found:
                raise self._words.error(part, f"{part.word} is stated twice in one view")
            found[part.word] = self._words.numbers(part, VIEW[part.word])
        missing = [part for part in ("from", "at", "up", "angle", "resolution") if part not in found]
        if missing:
            raise self._words.error(line, f"the view v has no {', '.join(missing)}; allowed is {', '.join(VIEW)}")
        if found.get("hither", [0])[0] > 0:
            self._note(line, "hither of the view is left out: what is nearer is seen too")
        (angle,), sides = found["angle"], found["resolution"]
        if not 0 < angle < 180:
            raise self._words.error(line, f"angle = {angle:g} of the view; allowed is between 0 and 180 degrees")
        if not all(side.is_integer() and 1 <= side <= 32768 for side in sides):
            raise self._words.error(line, f"resolution {sides[0]:g} {sides[1]:g}; allowed is whole numbers to 32768")
        width, height = map(int, sides)
        self._camera = Camera(
            found["from"], found["at"], view_angle(angle, height), width, height, found["up"],
            place=self._words.place(line, "the view v"),
        )  # fmt: skip

    def _sky(self, line: Line) -> None:
        self._background = ConstantBackground(self._words.numbers(line, 3), place=self._words.place(line, "b"))

    def _light(self, line: Line) -> None:
        numbers = self._words.numbers(line, 3, 6)
        if len(self._lights) == MOST_LIGHTS:
            raise self._words.error(line, f"more than {MOST_LIGHTS} lights; allowed is fewer")
        place, colour = np.asarray(numbers[:3]), np.asarray(numbers[3:])
        if (colour < 0).any():
            raise self._words.error(line, f"the light's colour {colour.tolist()}; allowed is >= 0")
        self._lights.append((place, colour if len(colour) else None))

    def _material(self, line: Line) -> None:
        r, g, b, k_d, k_s, shine, k_t, index = self._words.numbers(line, 8)
        place = self._words.place(line, "f")
        if k_t == 0 or index == 0:
            index = 1.0
        elif index < 1:
            self._note(line, f"index {index:g} of a material is below 1, and is taken for 1")
            index = 1.0
        sent = k_d * np.asarray([r, g, b])
        material = Material(
            k_a=sent, k_d=sent, k_h=k_s, k_s=k_s, k_t=k_t, phong_exponent=shine, refractive_index=index, place=place
        )
        self._fill = self._things.fill((r, g, b, k_d, k_s, shine, k_t, index), material)

    def _filled(self, line: Line) -> Fill:
        if self._fill is None:
            raise self._words.error(line, f"{KINDS[line.word]} before the first material; write a line f above it")
        return self._fill

    def _size(self, line: Line, radius: float) -> float:
        """A radius; one below 0 means a surface seen from within."""
        if radius < 0:
            self._note(line, "a radius below 0, which means a surface seen from within, is taken for one above 0")
        return abs(radius)

    def _sphere(self, line: Line) -> None:
        fill, (*centre, radius) = self._filled(line), self._words.numbers(line, 4)
        if radius == 0:
            return self._note(line, "a sphere of radius 0 is left out")
        fill.spheres.extend((*centre, self._size(line, radius)))

    def _cone(self, line: Line) -> None:
        fill = self._filled(line)
        first, second = self._words.words_below(line, 2, 4)
        (*base, low), (*top, high) = first, second
        low, high = self._size(line, low), self._size(line, high)
        if base == top or low == high == 0:
            return self._note(line, "a cone without a length or a radius is left out")
        self._things.frustum(self._words.place(line, "c"), fill, base, top, low, high)

    def _polygon(self, line: Line) -> None:
        fill, smooth = self._filled(line), line.word == "pp"
        count = self._words.count(line)
        corners = np.asarray(self._words.words_below(line, count, 6 if smooth else 3))
        if _has_no_area(corners[:, :3]):
            return self._note(line, "a polygon without an area is left out")
        if smooth and not (corners[:, 3:] != 0).any(axis=1).all():
            self._note(line, "a patch with a normal 0 0 0 is taken for a polygon")
            smooth = False
        (fill.patches if smooth else fill.polygons).add(corners)


def _has_no_area(corners: np.ndarray) -> bool:
    away = corners - corners[0]
    area = np.linalg.norm(np.cross(away[1:-1], away[2:]).sum(axis=0))
    return not area > 1e-12 * (away**2).sum(axis=1).max()


NFF = SceneFormat("NFF", (".nff",), parse_nff)
