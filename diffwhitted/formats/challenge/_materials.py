"""Materials of "The Ray Tracer Challenge": colour times ambient, diffuse, ...; patterns of two colours."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..others._boards import board_of
from ..others._found import Found, Paint
from ._nodes import Entry
from ._transforms import transform_of

USUAL: dict[str, float] = {
    "ambient": 0.1,
    "diffuse": 0.9,
    "specular": 0.9,
    "shininess": 200.0,
    "reflective": 0.0,
    "transparency": 0.0,
    "refractive-index": 1.0,
}
BOARDS = {"checkers": "xyz", "checker": "xyz", "stripes": "x", "stripe": "x"}
SHADOW_KEYS = {"shadow", "casts-shadow"}
DEEPEST = 32


class Materials:
    """The materials that shapes state, by their names in the scene."""

    def __init__(self, found: Found, defined: Mapping[str, Entry], extends: Mapping[str, str]):
        self._found, self._defined, self._extends = found, defined, extends
        self._mirroring_glass: set[str] = set()

    def named(self, stated: Entry | None, matrix: np.ndarray, kind: str) -> str:
        """The name of a material: as it was defined, or the kind of the shape. `matrix` (4, 4) is where that stands,
        and its pattern with it.
        """
        keys, name = self._keys(stated)
        unknown = [key for key in keys if key not in USUAL and key not in ("color", "pattern", *SHADOW_KEYS)]
        if unknown:
            allowed = ", ".join(("color", "pattern", *USUAL))
            raise keys[unknown[0]].error(f"unknown key {unknown[0][:40]!r} of a material; allowed is {allowed}")
        for key in SHADOW_KEYS & {*keys}:
            self._found.lost.say(f"{key} of a material is lost")
        value = {key: keys[key].number(key) if key in keys else usual for key, usual in USUAL.items()}
        for key, number in value.items():
            if number < 0:
                raise keys[key].error(f"{key} = {number:g}; allowed is 0 or more")
        index = value["refractive-index"]
        if index < 1:
            self._found.lost.say(f"a refractive-index of {index:g} is taken for 1")
            index = 1.0
        coefficients: dict[str, Any] = {
            "k_h": value["specular"],
            "k_s": value["reflective"],
            "k_t": value["transparency"],
            "phong_exponent": value["shininess"],
            "refractive_index": index if value["transparency"] else 1.0,
        }
        boards = {}
        colour = keys["color"].numbers("color") if "color" in keys else np.ones(3)
        if "pattern" in keys:
            colours, board = self._pattern(keys["pattern"], matrix)
            colour = colours.mean(axis=0)
            if board is not None:
                boards = {
                    name: board.painted(share * colours)
                    for name, share in (("k_a", value["ambient"]), ("k_d", value["diffuse"]))
                    if share > 0
                }
        coefficients |= {"k_a": value["ambient"] * colour, "k_d": value["diffuse"] * colour}
        # What mirrors and lets light through shares it out by Schlick's polynomial.
        shares = bool(value["reflective"] and value["transparency"])
        paint = Paint(coefficients, "reflected", boards, "schlick" if shares else "off")
        made = self._found.material(paint, name or kind)
        if shares and value["reflective"] != 1:
            self._mirroring_glass.add(made)
        return made

    def tell(self) -> None:
        """Say at the end of the file what all materials of a kind lose."""
        for name in sorted(self._mirroring_glass):
            self._found.lost.say(
                "the transmitted light of {} is 1 - F reflective of its transparency, in place of 1 - F",
                ("material", name),
            )

    def _keys(self, stated: Entry | None) -> tuple[dict[str, Entry], str | None]:
        """All keys of a material, those of what it extends below its own, and the name that it is defined under."""
        if stated is None:
            return {}, None
        if stated.is_table:
            return stated.table("material"), None
        found: dict[str, Entry] = {}
        name: str | None = stated.word("material")
        first = name
        for _ in range(DEEPEST):
            if name not in self._defined:
                raise stated.error(f"material {name!r} is not defined above")
            found = self._defined[name].table(f"material {name!r}") | found
            name = self._extends.get(name)
            if name is None:
                return found, first
        raise stated.error(f"material {first!r} extends more than {DEEPEST} others; allowed is fewer")

    def _pattern(self, entry: Entry, matrix: np.ndarray):
        """The two colours (2, 3) of a pattern, and its board if it is one that stands straight."""
        keys = entry.table("pattern")
        kind = keys["type"].word("type") if "type" in keys else ""
        if "colors" not in keys:
            self._found.lost.say(f"a pattern ({kind or 'without a type'}) is lost: it is grey")
            return np.full((2, 3), 0.5), None
        stated = keys["colors"].entries("colors")
        if len(stated) != 2 or not all(one.is_list for one in stated):
            self._found.lost.say(f"a pattern ({kind}) of other than two colours is lost: it is grey")
            return np.full((2, 3), 0.5), None
        colours = np.stack([one.numbers("colors") for one in stated])
        if kind not in BOARDS:
            self._found.lost.say(f"a pattern ({kind}) is lost: it is its mean colour")
            return colours, None
        place = matrix @ transform_of(keys["transform"], self._defined) if "transform" in keys else matrix
        board = board_of(colours, place, BOARDS[kind])
        if board is None:
            self._found.lost.say(f"a pattern ({kind}) that is turned or stretched is lost: it is its mean colour")
        return colours, board
