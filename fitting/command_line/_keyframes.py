"""`--set NAME=VALUE:VALUE`: numbers of a scene along keyframes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from diffwhitted import InputError

from ._between import Between

if TYPE_CHECKING:
    from diffwhitted import Scene

ALLOWED = (
    "NAME=V0:V1, such as glass.k_d=0.1:0.5 or light.key.position=[0,3,1]:[2,3,1] (more values are more keyframes), "
    "NAME=V, or NAME=orbit:360"
)
ORBIT = "orbit"


@dataclass(frozen=True)
class Course:
    """One number of the scene, or its components together, over a film; times go from 0 to 1."""

    name: str
    keys: np.ndarray
    """(keyframes, numbers)."""
    between: Between
    centre: np.ndarray | None = None
    """Of an orbit about the vertical through it: the keys are angles in degrees."""
    """(3,)."""
    start: np.ndarray | None = None
    """The place at the begin of an orbit, (3,)."""
    several: bool = True
    """The value has components."""

    @property
    def closed(self) -> bool:
        """Does it end where it begins?"""
        return self.centre is not None and bool(self.keys[-1, 0] % 360 == 0)

    def at(self, time: float) -> np.ndarray:
        """The value at a time."""
        value = _between(self.keys, time, self.between)
        return value if self.centre is None or self.start is None else _turned(self.start, self.centre, value[0])


def courses(scene: Scene, camera: str, given: Sequence[str], between: Between) -> list[Course]:
    """The courses of `--set`. Raises `InputError` for what is none, and `SceneError` for an unknown number."""
    found = [_course(scene, camera, text, between) for text in given]
    for number, course in enumerate(found):
        if any(course.name == other.name for other in found[:number]):
            raise InputError(f"--set {course.name}: it is stated twice; allowed is once")
    return found


def scene_at(scene: Scene, found: Sequence[Course], time: float) -> Scene:
    """The scene with its numbers as they are at a time. Raises `SceneError` for values that are not allowed."""
    from diffwhitted import replace_parameter

    for course in found:
        value = course.at(time)
        scene = replace_parameter(scene, course.name, value if course.several else float(value[0]))
    return scene


def times(found: Sequence[Course], frames: int) -> np.ndarray:
    """The time of each frame; a film that ends where it begins leaves its last moment to the first frame."""
    return np.arange(frames) / max(1, frames if found and all(c.closed for c in found) else frames - 1)


def _course(scene: Scene, camera: str, text: str, between: Between) -> Course:
    from diffwhitted import parameter_value

    name, equals, values = text.partition("=")
    if not (equals and name.strip() and values.strip()):
        raise InputError(f"--set {text}: allowed is {ALLOWED}")
    value: Any = np.asarray(parameter_value(scene, name.strip()), np.float64)
    parts = values.split(":")
    if parts[0].strip() == ORBIT:
        if value.shape != (3,) or len(parts) != 2:
            raise InputError(
                f"--set {text}: allowed is NAME=orbit:DEGREES, of a place such as camera.{camera}.look_from, which "
                "turns about the vertical through what the camera looks at"
            )
        centre = np.asarray(scene.cameras[camera].look_at, np.float64)
        end = _numbers(text, parts[1])
        if end.size != 1:
            raise InputError(f"--set {text}: {parts[1]!r} is not one number of degrees; allowed is {ALLOWED}")
        return Course(name.strip(), np.asarray([[0.0], end]), between, centre, value)
    keys = [_numbers(text, part) for part in parts]
    for part, key in zip(parts, keys, strict=True):
        if key.shape != np.ravel(value).shape:
            has = f"{part.strip()!r} has {key.size} numbers, and {name.strip()} has {value.size}"
            raise InputError(f"--set {text}: {has}; allowed is {ALLOWED}")
    return Course(name.strip(), np.stack(keys), between, several=bool(value.shape))


def _numbers(text: str, part: str) -> np.ndarray:
    try:
        found = np.asarray([float(number) for number in part.strip().strip("[]()").split(",")])
    except ValueError:
        found = np.asarray([np.nan])
    if not np.isfinite(found).all():
        raise InputError(
            f"--set {text}: {part.strip()!r} is not a number, or several with commas; allowed is {ALLOWED}"
        )
    return found


def _between(keys: np.ndarray, time: float, between: Between) -> np.ndarray:
    """Through evenly spaced keyframes: along straight lines, or by cubics that begin and end at rest (Catmull-Rom)."""
    if len(keys) == 1:
        return keys[0]
    place = float(np.clip(time, 0, 1)) * (len(keys) - 1)
    first = min(int(place), len(keys) - 2)
    share = place - first
    one, other = keys[first], keys[first + 1]
    if between is Between.linear:
        return one + share * (other - one)
    slope = np.zeros_like(keys)
    slope[1:-1] = (keys[2:] - keys[:-2]) / 2
    s = share
    return (
        (2 * s**3 - 3 * s**2 + 1) * one
        + (s**3 - 2 * s**2 + s) * slope[first]
        + (3 * s**2 - 2 * s**3) * other
        + (s**3 - s**2) * slope[first + 1]
    )


def _turned(place: np.ndarray, centre: np.ndarray, degrees: float) -> np.ndarray:
    """A place turned about the vertical through another one, counter-clockwise seen from above."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.asarray([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])
    return centre + turn @ (place - centre)
