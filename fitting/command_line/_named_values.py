"""Values that come with a name: `NAME=VALUE`, `NAME=LOW:HIGH`, `CAMERA=FILE`, and true values from a file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from diffwhitted import InputError, SceneError, load_scene
from diffwhitted._files import not_a_file
from fitting.problem._freedoms import read
from fitting.problem._unknowns import Unknown

if TYPE_CHECKING:
    from diffwhitted import Scene


def numbers(option: str, given: Sequence[str], allowed: str = "NAME=VALUE, such as glass.k_d=0.3") -> dict[str, float]:
    """From `NAME=VALUE`; raises `InputError` for anything else."""
    return {
        name: _number(option, text, value, allowed) for text in given for name, value in [_split(option, text, allowed)]
    }


def starts(option: str, given: Sequence[str]) -> dict[str, float | tuple[float, ...]]:
    """From `NAME=VALUE` or `NAME=R,G,B`, with or without brackets; raises `InputError` for anything else."""
    allowed, found = "NAME=VALUE, such as glass.k_d=0.3, or NAME=R,G,B, such as red.k_d=0.5,0.3,0.1", {}
    for text in given:
        name, value = _split(option, text, allowed)
        parts = value.strip().removeprefix("[").removesuffix("]").split(",")
        values = tuple(_number(option, text, part, allowed) for part in parts)
        found[name] = values if len(parts) > 1 else _number(option, text, parts[0], allowed)
    return found


def priors(option: str, given: Sequence[str]) -> dict[str, tuple[float, float]]:
    """From `NAME=MEAN+-DEVIATION` or `NAME=MEAN±DEVIATION`; raises `InputError` for anything else."""
    allowed, found = "NAME=MEAN+-DEVIATION, such as glass.refractive_index=1.5+-0.02", {}
    for text in given:
        name, value = _split(option, text, allowed)
        mean, sign, deviation = value.replace("±", "+-").partition("+-")
        if not sign:
            raise InputError(f"{option} {text}: allowed is {allowed}")
        found[name] = (_number(option, text, mean, allowed), _number(option, text, deviation, allowed))
    return found


def ties(option: str, given: Sequence[str]) -> dict[str, str]:
    """From `NAME=OTHER` or `NAME=0.5*OTHER`; raises `InputError` for anything else."""
    found = {}
    for text in given:
        name, value = _split(option, text, "NAME=OTHER, such as mirror.k_h=mirror.k_s, or NAME=0.5*OTHER")
        if name in found:
            raise InputError(f"{option}: {name} follows {found[name]} and {value}; allowed is one")
        found[name] = value
    return found


def intervals(option: str, given: Sequence[str]) -> dict[str, tuple[float, float]]:
    """From `NAME=LOW:HIGH`; raises `InputError` for anything else."""
    allowed, found = 'NAME=LOW:HIGH, such as "*.phong_exponent=5:500"', {}
    for text in given:
        name, ends = _split(option, text, allowed)
        low, colon, high = ends.partition(":")
        if not colon:
            raise InputError(f"{option} {text}: allowed is {allowed}")
        found[name] = (_number(option, text, low, allowed), _number(option, text, high, allowed))
    return found


def files_of_cameras(option: str, given: Sequence[str], cameras: Mapping, default: str | None) -> dict[str, Path]:
    """From `CAMERA=FILE`, or `FILE` for the default camera; raises `InputError` for two files of one camera."""
    found = {}
    for text in given:
        camera, equals, path = text.partition("=")
        if not equals or (camera not in cameras and Path(text).exists()):
            camera, path = default, text
        if camera is None:
            raise InputError(f"{option} {text}: which camera? Allowed is CAMERA=FILE, with {', '.join(cameras)}")
        if camera not in cameras:
            raise InputError(f"{option} {text}: the scene has no camera {camera!r}; there is {', '.join(cameras)}")
        if camera in found:
            raise InputError(
                f"{option}: two files for camera {camera!r}, {found[camera]} and {path}; "
                f"allowed is one a camera, as in {option} CAMERA=FILE"
            )
        found[camera] = Path(path)
    return found


def true_values(path: Path, scene: Scene, unknowns: Sequence[Unknown]) -> dict[str, float]:
    """True values by the names of the unknowns, from a scene or from JSON {name: value}; angles are counted from
    `scene`.

    Raises `InputError` where the file cannot be read or holds none of them.
    """
    known = _from_scene(path, scene, unknowns) if path.suffix.lower() == ".toml" else _of_json(path, unknowns)
    if not known:
        raise InputError(
            f"--truth {path}: it holds none of the free coefficients {', '.join(u.name for u in unknowns)}"
        )
    return known


def _from_scene(path: Path, scene: Scene, unknowns: Sequence[Unknown]) -> dict[str, float]:
    other, known = load_scene(path), {}
    for unknown in unknowns:
        try:
            values = read(scene, unknown.parameter, other)
        except (SceneError, LookupError, AttributeError):
            continue  # The other scene has no such record.
        known[unknown.name] = float(values[unknown.part if len(values) > 1 else 0])
    return known


def _of_json(path: Path, unknowns: Sequence[Unknown]) -> dict[str, float]:
    held, known = _from_json(path), {}
    for unknown in unknowns:
        value = held.get(unknown.name, held.get(unknown.parameter.name))
        if value is not None:
            values = np.ravel(value)
            known[unknown.name] = float(values[unknown.part if len(values) > unknown.part else 0])
    return known


def _from_json(path: Path) -> dict:
    if kind := not_a_file(path):
        raise InputError(f"--truth {path}: this is {kind}; write the values to a file and give its name")
    try:
        held = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"--truth {path}: cannot be read ({(error.strerror or str(error)).lower()}); check the name"
        ) from None
    except ValueError as error:
        raise InputError(f"--truth {path}: neither a scene (.toml) nor JSON: {error}") from None
    if not isinstance(held, dict) or not all(_is_value(value) for value in held.values()):
        raise InputError(
            f'--truth {path}: allowed is {{"NAME": NUMBER, ...}}, or three numbers for a colour or a place'
        )
    return held


def _is_value(value) -> bool:
    parts = value if isinstance(value, list) and len(value) in (1, 3) else [value]
    return all(isinstance(part, (int, float)) and not isinstance(part, bool) for part in parts)


def _split(option: str, text: str, allowed: str) -> tuple[str, str]:
    name, equals, value = text.rpartition("=")
    if not (equals and name):
        raise InputError(f"{option} {text}: allowed is {allowed}")
    return name, value


def _number(option: str, text: str, value: str, allowed: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = float("nan")
    if not np.isfinite(number):
        raise InputError(f"{option} {text}: {value!r} is not a number; allowed is {allowed}")
    return number
