"""A fit of 18 coefficients from the middle of their bounds, compile included, with the error of each beside it."""

import time
from dataclasses import asdict
from pathlib import Path

import jax
import numpy as np

import diffwhitted
import fitting

from . import _mitsuba
from ._figures import Figure
from ._fresh import in_fresh_process, run
from ._scene import CAMERA, FOLDER, TARGET_SIZE, UNKNOWNS, three_spheres

SECONDS_TARGET, ERROR_TARGET, POVRAY_TARGET = 8.0, 1e-5, 0.02
RUNS = 3
POVRAY_PICTURES = tuple(
    FOLDER.parent / name for name in ("tests/targets/three_spheres.exr", "examples/three_spheres_povray.exr")
)


def measure() -> list[Figure]:
    own = min((in_fresh_process("fit", "own") for _ in range(RUNS)), key=lambda found: found["seconds"])
    figures = [
        Figure(
            "fit of 18 numbers, compile included",
            own["seconds"],
            "s",
            SECONDS_TARGET,
            f"320x240, depth 5, from the middle of the bounds; shortest of {RUNS} processes; compile "
            f"{own['compile']:.2f} s, {own['steps']} steps {own['solve']:.2f} s; {own['status']}",
        ),
        Figure("largest error of a coefficient", own["worst"], "", ERROR_TARGET, _listed(own["errors"])),
    ]
    return [*figures, *_coarse_to_fine(), *_against_povray(), *_against_mitsuba(own)]


def _coarse_to_fine() -> list[Figure]:
    """640x480, in turns in one process, after a first fit each."""
    found = in_fresh_process("fit", "stages")
    ways = {way: [run["solve"] for run in runs] for way, runs in found.items()}
    ratios = [coarse / all_pixels for coarse, all_pixels in zip(ways["coarse"], ways["all"], strict=True)]
    stages = "; ".join(f"{s['name']}: {s['steps']} steps, {s['seconds']:.2f} s" for s in found["coarse"][-1]["stages"])
    return [
        Figure(
            "640x480: time from coarse to fine / with all pixels from the start",
            float(np.median(ratios)),
            "",
            0.5,
            f"{np.median(ways['coarse']):.2f} s and {np.median(ways['all']):.2f} s after compiling; {stages}; "
            f"largest error {found['coarse'][-1]['worst']:.1g} and {found['all'][-1]['worst']:.1g}",
        )
    ]


def _listed(errors: dict[str, float]) -> str:
    return ", ".join(f"{name} {error:.1g}" for name, error in errors.items())


def _against_povray() -> list[Figure]:
    name = "largest error, POV-Ray's picture as target"
    picture = next((p for p in POVRAY_PICTURES if p.exists()), None)
    if picture is None:
        return [Figure(name, None, "", POVRAY_TARGET, "its picture is not there")]
    found = in_fresh_process("fit", "povray", picture)
    return [
        Figure(
            name,
            found["worst"],
            "",
            POVRAY_TARGET,
            f"{found['seconds']:.1f} s, {found['steps']} steps; {found['status']}; {_listed(found['errors'])}",
        )
    ]


def _against_mitsuba(own: dict) -> list[Figure]:
    found = _mitsuba.ask("fit")
    name = "Mitsuba 3 + Adam, largest error of a coefficient"
    if isinstance(found, str):
        return [Figure(name, None, "", None, found)]
    reached = ", ".join(f"{error} after {seconds:.0f} s" for error, seconds in found["reached"].items()) or "not 0.1"
    return [
        Figure(
            name,
            found["worst"],
            "",
            None,
            f"after {found['seconds']:.0f} s, {found['steps']} steps ({reached}) on {found['unknowns']} numbers "
            f"of its own model, on its own picture; this project: {own['worst']:.1g} after {own['seconds']:.1f} s",
        )
    ]


def _fitted(source: str, picture: str = "") -> dict:
    """In this process: fit a picture of our own, or the one in a file; or fit a large one with and without stages."""
    if source == "stages":
        return _with_and_without_stages()
    truth = three_spheres(TARGET_SIZE)
    camera = truth.cameras[CAMERA]
    target = (
        diffwhitted.read_image(Path(picture)).pixels
        if source == "povray"
        else np.asarray(diffwhitted.render(truth, camera))
    )
    jax.clear_caches()
    begun = time.perf_counter()
    result = fitting.fit(truth, target, free=UNKNOWNS, start=_middle_of_bounds())
    seconds = time.perf_counter() - begun
    errors = {c.name: _error(c, truth) for c in result.coefficients}
    return {
        "seconds": seconds,
        "compile": result.seconds_compile,
        "solve": result.seconds_solve,
        "steps": result.steps,
        "status": result.status,
        "errors": errors,
        "worst": max(errors.values()),
    }


def _with_and_without_stages() -> dict:
    truth = three_spheres()
    target, runs = np.asarray(diffwhitted.render(truth, truth.cameras[CAMERA])), {"coarse": [], "all": []}
    for _ in range(1 + RUNS):
        for way, found in runs.items():
            result = fitting.fit(
                truth, target, free=UNKNOWNS, start=_middle_of_bounds(), coarse_to_fine=way == "coarse"
            )
            found.append(
                {
                    "solve": result.seconds_solve,
                    "worst": max(_error(c, truth) for c in result.coefficients),
                    "stages": [asdict(stage) for stage in result.stages],
                }
            )
    return {way: found[1:] for way, found in runs.items()}


def _middle_of_bounds() -> dict[str, float]:
    middle = {
        row.name: float(np.sqrt(np.prod(ends)) if row.scale == "log" else np.mean(ends))
        for row in diffwhitted.COEFFICIENTS
        if (ends := row.fit_bounds)
    }
    return {f"*.{name}": float(middle[name]) for name in {u.rpartition(".")[2] for u in UNKNOWNS}}


def _error(coefficient: fitting.FittedCoefficient, truth) -> float:
    """Of an exponent relative to its value, of all others as they are."""
    name, _, channel = coefficient.name.rpartition(".")
    channels = ("r", "g", "b")
    full = coefficient.name if channel not in channels else name
    values = np.atleast_1d(np.asarray(diffwhitted.coefficient_value(truth, full), np.float64))
    value = values[channels.index(channel) if channel in channels else 0]
    error = abs(coefficient.value - value)
    return float(error / value if full.endswith("exponent") else error)


if __name__ == "__main__":
    run("fit", measure, _fitted)
