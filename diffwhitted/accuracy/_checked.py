"""Values of knobs, checked: each function gives the value back, or raises `SceneError` saying what is allowed."""

from .._errors import SceneError
from ..rendering._antialias import check_threshold
from ..scene import check_footprint
from ..shapes import SHADING
from ._materials import BOTH

STATED = "stated"
"""The shading that each mesh states."""


def checked_footprint(value) -> int:
    check_footprint(value, "")
    return value


def checked_cutoff(value) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < 1:
        raise SceneError(f"cutoff = {value!r}; allowed is 0 (follow every branch) or more, below 1")
    return float(value)


def checked_antialias(value) -> float:
    if value != 0:
        check_threshold(value)
    return float(value)


def checked_precision(value) -> str:
    if value not in ("float32", "float64"):
        raise SceneError(f"precision = {value!r}; allowed is float32, float64")
    return value


def checked_fresnel(value) -> str | None:
    if value not in (None, *BOTH):
        raise SceneError(f"fresnel = {value!r}; allowed is {', '.join(BOTH)}")
    return value


def checked_shading(value) -> str:
    if value not in (STATED, *SHADING):
        raise SceneError(f"shading = {value!r}; allowed is {', '.join((STATED, *SHADING))}")
    return value
