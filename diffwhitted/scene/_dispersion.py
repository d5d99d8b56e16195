"""How a refractive index changes with the wavelength: what a material may state, and what becomes of it.

    { abbe = 60 } | { cauchy = [A, B] } | { sellmeier = [[B1, ...], [C1, ...]] } | "N-BK7"

The first two are a two-term Cauchy through n_d = `refractive_index`, of Abbe number V. The others are a curve whose
course is kept as it is; a `refractive_index` that is stated beside it, or fitted, moves the whole of it.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from .._errors import SceneError
from ..optics import (
    CATALOGUE_NAMES,
    LINE_C,
    LINE_D,
    LINE_F,
    abbe_number,
    catalogue_lines,
    cauchy_index,
    cauchy_through,
    sellmeier_index,
    wavelengths,
)  # fmt: skip
from ..records import nearest_name

Curve = str | tuple[tuple[float, ...], tuple[float, ...]]
"""The name of a substance, or the constants of Sellmeier's formula."""


def read_dispersion(stated: Any, place: str) -> tuple[dict[str, float], Curve | None]:
    """The coefficients that a statement stands for, and the curve that it names, if any. Raises `SceneError`."""
    if stated is None:
        return {}, None
    if isinstance(stated, str):
        lines = catalogue_lines(stated)
        if lines is None:
            raise SceneError(
                f"{place}: dispersion = {stated!r} is no substance of the catalogue; there is "
                f"{', '.join(CATALOGUE_NAMES)}.{nearest_name(stated, CATALOGUE_NAMES)} Or write "
                "{ abbe = V }, { cauchy = [A, B] } or { sellmeier = [[B1, ...], [C1, ...]] }"
            )
        return {"refractive_index": lines[1]}, stated
    if not isinstance(stated, Mapping) or len(stated) != 1 or next(iter(stated)) not in ("abbe", "cauchy", "sellmeier"):
        raise SceneError(
            f"{place}: dispersion = {stated!r}; allowed is one of {{ abbe = V }}, {{ cauchy = [A, B] }}, "
            '{ sellmeier = [[B1, ...], [C1, ...]] } and the name of a substance, such as "N-BK7"'
        )
    (kind, given) = next(iter(stated.items()))
    numbers = _numbers(given, f"{place}: dispersion.{kind}")
    if kind == "abbe":
        if numbers.shape != () or not numbers > 0:
            raise SceneError(f"{place}: dispersion.abbe = {given!r}; allowed is a number > 0, mostly 20 to 100")
        return {"abbe_number": float(numbers)}, None
    if kind == "cauchy":
        if numbers.shape != (2,) or not (numbers[0] >= 1 and numbers[1] > 0):
            raise SceneError(
                f"{place}: dispersion.cauchy = {given!r}; allowed is [A, B] with A >= 1 and B > 0 (square micrometres)"
            )
        red, middle, blue = (float(cauchy_index(numbers, line)) for line in (LINE_C, LINE_D, LINE_F))
        return {"refractive_index": middle, "abbe_number": abbe_number(red, middle, blue)}, None
    if numbers.ndim != 2 or numbers.shape[0] != 2 or any(0.14 < c < 0.6 for c in numbers[1]):
        raise SceneError(
            f"{place}: dispersion.sellmeier = {given!r}; allowed is [[B1, ...], [C1, ...]], as many B as C, C in "
            "square micrometres and none from .14 to .6, as a resonance in visible light"
        )
    curve = tuple(map(float, numbers[0])), tuple(map(float, numbers[1]))
    return {"refractive_index": float(sellmeier_index(*curve, LINE_D))}, curve


def departures(curve: Curve | None, bands: int) -> Float[np.ndarray, "bands"]:
    """By how much the index of a curve departs from that at the line d, in the middle of each band."""
    if curve is None:
        return np.zeros(bands)
    if isinstance(curve, str):
        constants = cauchy_through(catalogue_lines(curve) or (1.0,) * 4)
        return np.asarray(cauchy_index(constants, wavelengths(bands)) - cauchy_index(constants, LINE_D))
    return sellmeier_index(*curve, wavelengths(bands)) - sellmeier_index(*curve, LINE_D)


def written_dispersion(curve: Curve | None) -> Any:
    """As a file states it; None without one."""
    return curve if curve is None or isinstance(curve, str) else {"sellmeier": [list(part) for part in curve]}


def _numbers(given, place: str) -> np.ndarray:
    try:
        numbers = np.asarray(given, np.float64)
    except (TypeError, ValueError) as error:
        raise SceneError(f"{place} = {given!r} is not a number or a list of numbers") from error
    if not np.isfinite(numbers).all():
        raise SceneError(f"{place} = {given!r}; allowed are finite numbers")
    return numbers
