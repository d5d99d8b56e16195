"""Tolerances as a person writes them, and choices of settings that are remembered beside the scene."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from diffwhitted import Choice, Scene, Settings
    from diffwhitted.scene import AbstractCamera

    from ._render import Picture

REMEMBERED = 16
"""Choices a file keeps, the latest ones."""


def tolerance_number(text: str, option: str = "--tolerance") -> float:
    """A number above 0, such as 0.004 or 1/255. Raises `InputError` for anything else."""
    from fractions import Fraction
    from math import isfinite

    from diffwhitted import InputError

    try:
        value = float(Fraction(text.replace(" ", "")))
    except (ValueError, ZeroDivisionError, OverflowError):
        value = 0.0
    if not (isfinite(value) and value > 0):
        raise InputError(f"{option} {text}: allowed is a number above 0, or a fraction such as 1/255")
    return value


def accuracy_bound(tolerance: str | None, time_budget: float | None, **settings: Any) -> dict[str, float]:
    """What `diffwhitted.choose` is asked for. Raises `InputError` where that is not one thing, or settings stand
    beside it.
    """
    from diffwhitted import InputError

    if tolerance is not None and time_budget is not None:
        raise InputError("--tolerance with --time-budget: allowed is one of the two")
    asked = "--tolerance" if tolerance is not None else "--time-budget"
    beside = [name for name, value in settings.items() if value is not None]
    if beside:
        raise InputError(f"{asked} with --{beside[0]}: {asked} finds the {beside[0]} itself; give one of the two")
    if tolerance is not None:
        return {"tolerance": tolerance_number(tolerance)}
    if time_budget is None or not 0 < time_budget < float("inf"):
        raise InputError(f"--time-budget {time_budget}: allowed is a number of seconds above 0")
    return {"time_budget": time_budget}


def found_picture(
    path: Path, scene: Scene, camera: AbstractCamera, name: str, bound: dict[str, float]
) -> tuple[Settings, Picture, str]:
    """The picture within the bound, and a sentence on its settings and error."""
    from diffwhitted import measure

    from ._progress import Progress
    from ._render import Picture

    with Progress("looking for settings") as progress:
        settings, text, choice = remembered(path, scene, camera, name, bound, progress.say)
        found = choice.measured if choice is not None else measure(scene, camera, settings)
    return settings, Picture(found.image, found.rays, found.seconds, found.seconds_compile, None), text


def remembered(
    path: Path, scene: Scene, camera: AbstractCamera, name: str, bound: dict[str, float], on_work: Callable[[str], None]
) -> tuple[Settings, str, Choice | None]:
    """Settings that meet `bound`, a sentence on them, and the choice if it was made now rather than read.

    Choices are kept in a small file beside the scene, each under the scene's text, the view, the bound, the version
    and the machine; where that file cannot be read or written, settings are chosen anew in silence.
    """
    from diffwhitted import InputError, Settings, choose

    store, key = path.with_name(f".{path.stem}.choices.json"), _key(path, scene, camera, name, bound)
    kept = _read(store)
    try:
        if (known := kept.get(key)) is not None:
            return Settings(**known["settings"]), f"{known['text']} (found before; {store.name})", None
    except (InputError, KeyError, TypeError):
        pass
    choice = choose(scene, camera, **bound, on_work=on_work)
    text = sentence(choice, bound)
    kept.pop(key, None)
    _write(
        store, dict(list(kept.items())[1 - REMEMBERED :]) | {key: {"settings": asdict(choice.settings), "text": text}}
    )
    return choice.settings, text, choice


def sentence(choice: Choice, bound: dict[str, float]) -> str:
    """What was chosen, and how far it was then found to be from the reference."""
    from fitting.comparing._tradeoff import tolerance_text

    asked = f"within {tolerance_text(bound['tolerance'])}" if "tolerance" in bound else f"in {bound['time_budget']:g} s"
    return (
        f"{asked}: {choice.settings}; error {choice.error:.2g} (RMSE, linear RGB) on {choice.checked:,} pixels "
        f"that the search did not see, against {choice.checked_against}"
    )


def _key(path: Path, scene: Scene, camera: AbstractCamera, name: str, bound: dict[str, float]) -> str:
    import platform
    from hashlib import sha256

    from diffwhitted.numerics._workers import processors

    from . import version_line

    asked = [
        name,
        camera.width,
        camera.height,
        scene.precision,
        float(scene.cutoff),
        sorted(bound.items()),
        version_line(),
        platform.node(),
        processors(),
    ]
    return sha256(path.read_bytes() + json.dumps(asked).encode()).hexdigest()[:32]


def _read(store: Path) -> dict[str, Any]:
    from diffwhitted._files import not_a_file

    if not_a_file(store):
        return {}
    try:
        kept = json.loads(store.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return kept if isinstance(kept, dict) else {}


def _write(store: Path, kept: dict[str, Any]) -> None:
    from contextlib import suppress

    from fitting.telling._outputs import write_whole

    with suppress(OSError):
        write_whole(store, lambda path: path.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8"))
