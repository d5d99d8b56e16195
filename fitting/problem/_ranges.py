"""Where a fit looks for a number unless it is told: bounds from the table of its kind, or else from the scene
itself.
"""

from math import inf, isfinite

import numpy as np

from diffwhitted.records import Row
from diffwhitted.scene import Parameter, Scene, highest_coat

FACTOR = 4.0
"""A length on a scale of logarithms is looked for between this fraction of it and so many times it."""
BRIGHTER = 10.0
"""A colour is looked for up to so many times its largest channel."""
TURN, TURN_OF_LIGHT = 45.0, 90.0
"""Degrees; a direction is looked for so far to either side. Pictures tell where to begin with a lamp (`_lamps`)."""


def default_bounds(scene: Scene, parameter: Parameter, value: float, counted: bool, unit: str) -> tuple[float, float]:
    """The bounds of an unknown whose value in the scene is `value`; `counted`: from that of the scene.

    By the table of its kind where that has bounds, widened (twice as far as need be) where the scene's own value lies
    outside; otherwise places by the size of the scene, lengths by a factor of 4, colours up to 10 times what they are,
    directions 45 degrees to each side, those of lights 90.
    """
    row = parameter.row
    whole = np.asarray(parameter.value(scene), np.float64)
    if counted:
        turn = TURN_OF_LIGHT if parameter.family == "light" else TURN
        size = turn if unit == "deg" else scene_size(scene)
        return -size, size
    if row.fit_bounds is not None:
        low, high = _widened(row, row.fit_bounds, whole)
        return low, min(high, _highest(scene, parameter))
    if row.scale in ("log", "log-excess"):
        zero = row.measured_in.floor(row.lowest)
        return zero + (value - zero) / FACTOR, min(zero + (value - zero) * FACTOR, row.highest)
    if isfinite(row.lowest) and isfinite(row.highest):
        return row.lowest + 0.5 * (value - row.lowest), row.highest - 0.5 * (row.highest - value)
    if isfinite(row.lowest):
        return row.lowest, row.lowest + (BRIGHTER * float((whole - row.lowest).max()) or 1.0)
    size = scene_size(scene) if row.unit == "m" else max(2 * abs(value), 1.0)
    return max(value - size, row.lowest), min(value + size, row.highest)


def _highest(scene: Scene, parameter: Parameter) -> float:
    """What its material allows."""
    polished = parameter.family == "material" and parameter.row.name == "k_d"
    return highest_coat(scene.materials[parameter.owner]) if polished else inf


def scene_size(scene: Scene) -> float:
    """Metres; the longest side of a box around all that has an end, all lights that stand somewhere, and all
    cameras.
    """
    corners = [np.asarray(camera.look_from, np.float64) for camera in scene.cameras.values()]
    corners += [place for light in scene.lights if (place := light.place()) is not None]
    for thing in scene.placed_objects():
        middle, radius = thing.ball()
        if isfinite(radius):
            corners += [middle - radius, middle + radius]
    extent = float(np.ptp(np.stack(corners), axis=0).max()) if corners else 0.0
    return extent or 1.0


def _widened(row: Row, bounds: tuple[float, float], value: np.ndarray) -> tuple[float, float]:
    low, high = bounds
    if row.lowest < value.min() < low:
        lowest = row.lowest if isfinite(row.lowest) else low
        low = lowest + (0.5 if isfinite(row.lowest) else 2.0) * (float(value.min()) - lowest)
    return low, max(high, min(2 * float(value.max()), row.highest)) if value.max() > high else high


def checked_bounds(row: Row, counted: bool, ends: tuple[float, float]) -> str:
    """What is allowed of the bounds of an unknown, where these are not; else an empty string."""
    low, high = ends
    lowest, highest = (-inf, inf) if counted else (row.measured_in.floor(row.lowest), row.highest)
    # The end of a scale of logarithms is out of reach, and so is one that the row itself excludes.
    open_end = not counted and (row.measured_in.open or row.excluded)
    above = low > lowest if open_end else low >= lowest
    below = high < highest if open_end and row.excluded and isfinite(highest) else high <= highest
    if low < high and above and below:
        return ""
    allowed = "low < high"
    allowed += f" with low {'>' if open_end else '>='} {lowest:g}" if isfinite(lowest) else ""
    return allowed + (f" and high {'<' if row.excluded else '<='} {highest:g}" if isfinite(highest) else "")
