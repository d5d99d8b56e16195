"""Rows: what a record holds, said once.

Each record has a table of rows, one a key. The check of a value when a record is built, the keys of scene files and
their schema, the bounds and units of a fit and the names of its unknowns are all read from it.
"""

import operator
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any, Final, Literal

import numpy as np

from .._errors import SceneError
from ._checks import is_traced, number_array, require, whole_number
from ._scale import SCALES, Scale, ScaleName

REQUIRED: Final = object()
"""In place of a default: the key must be stated."""

Kind = Literal[
    "number", "vector", "direction", "colour", "number or colour", "number or vector", "numbers", "list", "vectors",
    "pairs", "colours", "texels", "matrix", "faces", "flag", "count", "text", "file", "choice",
]  # fmt: skip
Moves = Literal["nothing", "patterns", "shadows", "rays"]
Freedom = Literal["each", "turn", "roll", "flat"]

_SHAPES = {
    "number": ((),),
    "vector": ((3,),),
    "direction": ((3,),),
    "colour": ((), (3,)),
    "number or colour": ((), (3,)),
    "number or vector": ((), (3,)),
    "matrix": ((4, 4),),
}


@dataclass(frozen=True)
class Row:
    """One key of a record."""

    name: str
    kind: Kind
    meaning: str
    unit: str = "1"
    default: Any = REQUIRED
    """Where it is not stated; None where it may be absent."""
    lowest: float = -inf
    """Smallest value of each number."""
    highest: float = inf
    excluded: bool = False
    """The ends of the interval are not allowed themselves."""
    nonzero: bool = False
    """Not all numbers may be zero."""
    count: tuple[int, int | None] = (1, None)
    """Of lists: the fewest and the most entries."""
    grid: bool = False
    """Of vectors: a file may state rows of them, or rows of rows, in place of one after the other."""
    choices: tuple[str, ...] = ()
    pattern: str | None = None
    """Of text: what it must match."""
    below: str = ""
    """What to say to someone who gives less than is allowed."""
    symbol: str = ""
    source: str = ""
    """Paper and equation."""
    fit_bounds: tuple[float, float] | None = None
    """Interval in which a fit looks for it unless told otherwise; None: no bounds, or those that its scale needs."""
    scale: ScaleName = "interval"
    """In what the unknown of a fit is linear: the value between bounds, log(value), log(value - 1), or the value
    itself.
    """
    moves: Moves = "nothing"
    """What a change of it moves in the picture: nothing (weights and colours alone), the edges of patterns, shadows,
    or the rays themselves."""
    blurs: bool = False
    """It decides on how sharp the picture is, which residuals that are blurred do not show."""
    freedom: Freedom | None = None
    """What a fit changes in it: each of its numbers; its direction by a turn of two angles; by a roll of one angle
    about another direction; points within the plane in which they lie. None: by its kind, "turn" of a direction."""
    about: str = ""
    """Of a turn: the key of the point from which the direction goes to this one. Of a roll: two keys, "FROM TO", of the
    points between which the axis runs."""
    textured: bool = True
    """Of what may be a colour: may a texture multiply it?"""
    table: str = ""
    """In a file it is a key of this inline table of the record; its name is the table's, an underscore, and the key."""
    parts: tuple[str, ...] = ()
    """Names of its numbers, where r, g, b of a colour or x, y, z of a vector do not fit. Of the kind "numbers": one for
    each of them."""

    @property
    def numeric(self) -> bool:
        """Does it hold numbers that have names, one by one, and that a fit may look for?"""
        return self.kind not in ("texels", "text", "file", "choice", "flag", "count", "matrix", "faces")

    @property
    def coloured(self) -> bool:
        """May it be linear RGB?"""
        return self.kind in ("colour", "number or colour")

    @property
    def moves_rays(self) -> bool:
        return self.moves == "rays"

    @property
    def free_by(self) -> Freedom:
        """What a fit changes in it."""
        return self.freedom or ("turn" if self.kind == "direction" else "each")

    @property
    def measured_in(self) -> Scale:
        """Its scale."""
        return SCALES[self.scale]

    def _faces(self, value, place: str) -> tuple[tuple[int, ...], ...]:
        """Lists of numbers of corners."""
        try:
            found = tuple(tuple(operator.index(corner) for corner in face) for face in value)
        except TypeError as error:
            raise SceneError(f"{place}: {self.name} is not a list of lists of whole numbers") from error
        few, most = self.count
        if not few <= len(found) <= (most or len(found)):
            end = f" to {most}" if most else " on"
            raise SceneError(f"{place}: {self.name} has {len(found)} entries; allowed is from {few}{end}")
        short = next((number for number, face in enumerate(found) if len(face) < 3), None)
        if short is not None:
            raise SceneError(
                f"{place}: {self.name}: entry {short} has {len(found[short])} corners; allowed is 3 or more"
            )
        return found

    def components(self, shape: tuple[int, ...]) -> tuple[str, ...]:
        """The names of its numbers for a value of that shape, such as "r" or "2.y"; none for one number."""
        if not shape or self.kind == "texels":
            return ()
        if self.kind == "list":
            return tuple(map(str, range(shape[0])))
        names = self.parts or (("r", "g", "b") if self.coloured or self.kind == "colours" else ("x", "y", "z"))
        return tuple(f"{k}.{name}" for k in range(shape[0]) for name in names) if len(shape) == 2 else names

    def allowed(self) -> str:
        """The interval in words, such as ">= 0" or "between 0 and 180, both excluded"."""
        if self.excluded and isfinite(self.lowest) and isfinite(self.highest):
            return f"between {self.lowest:g} and {self.highest:g}, both excluded"
        above, below = (">", "<") if self.excluded else (">=", "<=")
        ends = [f"{above} {self.lowest:g}"] * isfinite(self.lowest) + [f"{below} {self.highest:g}"] * isfinite(
            self.highest
        )
        return " and ".join([*ends, *["any vector but zero"] * self.nonzero])

    def holds(self, value) -> bool:
        """Does a concrete value lie in the interval?"""
        inside = (
            (value > self.lowest) & (value < self.highest)
            if self.excluded
            else ((value >= self.lowest) & (value <= self.highest))
        )
        return bool(inside.all()) and (not self.nonzero or bool((value != 0).any()))

    def advice(self, value) -> str:
        """What else to say of a value that is not allowed."""
        if is_traced(value) or not self.below or (value > self.lowest).all():
            return ""
        return self.below

    def read(self, value, place: str) -> Any:
        """`value` as an array of this row, or `SceneError` naming the place, the value and what is allowed."""
        if self.kind == "flag":
            if isinstance(value, (bool, np.bool_)):
                return bool(value)
            raise SceneError(f"{place}: {self.name} = {value!r}; allowed is true or false")
        if self.kind == "count":
            lowest, highest = int(self.lowest), int(self.highest) if isfinite(self.highest) else None
            return whole_number(value, f"{place}: {self.name}", lowest, highest)
        if self.kind == "faces":
            return self._faces(value, place)
        each = 2 if self.kind == "pairs" else 3
        listed = ((len(self.parts),),) if self.kind == "numbers" else ((entries(value), each),)
        listed = ((), (entries(value),)) if self.kind == "list" else listed
        if self.kind == "texels":
            listed = (_picture_shape(value, place, self.name),)
        shapes = _SHAPES.get(self.kind, listed)
        array = number_array(value, place, self.name, shapes)
        if self.allowed():
            require(self.holds, place, self.name, array, self.allowed(), self.advice(array))
        return array if self.kind != "colour" or array.shape else array * np.ones(3, array.dtype)


def _picture_shape(value, place: str, name: str) -> tuple[int, ...]:
    """The shape of a picture of at least one texel. Raises `SceneError` for anything else."""
    shape = np.shape(value)
    if len(shape) != 3 or shape[2] != 3 or not shape[0] * shape[1]:
        raise SceneError(f"{place}: {name} has shape {shape}; allowed is (height, width, 3), linear RGB")
    return shape


def entries(value) -> int:
    """The length of a list; 1 of what is none, whose shape is then refused."""
    try:
        return len(value)
    except TypeError:
        return 1


def rows_of(record) -> dict[str, Row]:
    """The rows of a record, or of a class of records, by name."""
    return {row.name: row for row in record.ROWS}


def read_rows(record, place: str, **values) -> None:
    """Set the fields of a record that is being built, each checked by its row; None stays None where that is
    allowed.
    """
    rows = rows_of(record)
    for name, value in values.items():
        row = rows[name]
        setattr(record, name, None if value is None and row.default is None else row.read(value, place))
