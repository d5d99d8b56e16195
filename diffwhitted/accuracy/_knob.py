"""A row of the table of knobs, and which values each may have."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .._errors import SceneError
from ..rendering._antialias import check_threshold
from ..scene import check_footprint
from ..shapes import SHADING
from ._materials import BOTH

STATED = "stated"
"""The shading that each mesh states."""


@dataclass(frozen=True)
class Knob:
    """A row of the table.

    The knobs of a group do related work: of "pixel" (where a pixel is sampled) one at most is on, those of "tree"
    (how far a ray is followed) go together, and every choice of one group goes with every choice of the other.
    """

    name: str
    costs: str
    controls: str
    """Which error it makes smaller."""
    default: Any
    off: Any
    """The value at which it does nothing."""
    sweep: tuple
    group: str
    text: str
    """How a setting reads: "depth {}"."""
    argument: str | None
    """Of `diffwhitted.render`; None for what belongs to the scene."""
    check: Callable[[Any], Any] = field(repr=False)


def row(default: Any, **columns: Any) -> Any:
    """A field of `Settings` with its row of the table."""
    return field(default=default, metadata={"row": {"default": default, **columns}})


def footprint_of(value) -> int:
    check_footprint(value, "")
    return value


def cutoff_of(value) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < 1:
        raise SceneError(f"cutoff = {value!r}; allowed is 0 (follow every branch) or more, below 1")
    return float(value)


def antialias_of(value) -> float:
    if value != 0:
        check_threshold(value)
    return float(value)


def precision_of(value) -> str:
    if value not in ("float32", "float64"):
        raise SceneError(f"precision = {value!r}; allowed is float32, float64")
    return value


def fresnel_of(value) -> str | None:
    if value not in (None, *BOTH):
        raise SceneError(f"fresnel = {value!r}; allowed is {', '.join(BOTH)}")
    return value


def shading_of(value) -> str:
    if value not in (STATED, *SHADING):
        raise SceneError(f"shading = {value!r}; allowed is {', '.join((STATED, *SHADING))}")
    return value
