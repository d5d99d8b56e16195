"""A picture with settings and what it takes; the cheapest settings for a tolerance, or the most accurate for a time,
found on a part of the pixels.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite

import jax
import numpy as np

from .._errors import InputError
from ..records import changed, in_dtype
from ..scene import AbstractCamera, Scene, float_dtype, is_traced
from ._knobs import Settings
from ._reference import Reference, reference, rmse
from ._survey import Candidate, cheapest, survey
from ._tracer import Tracer

PART = 4096
"""So many pixels serve the search, and as many others the check."""
MARGIN = 0.9
"""An error that was measured on a part of the pixels is looked for below this part of the tolerance."""
MOST_TRIALS = 5
"""Whole pictures that are traced before the search ends."""
GOAL = 1e-3
"""How far the reference may be from converged where no tolerance is given."""
RUNS, RUNS_SECONDS = 5, 1.0
"""A picture is timed so often at most, and as long as these runs take no longer."""
SEED = 0


@dataclass(frozen=True, eq=False)
class Measured:
    """A picture with some settings, and what it took."""

    settings: Settings
    image: np.ndarray
    """(height, width, 3), linear Rec. 709 RGB, in the precision of the settings."""
    rays: int
    """Camera rays and all that follow from them, without shadow rays."""
    seconds: float
    """To trace it with its program compiled."""
    seconds_compile: float
    """Of all that was compiled for this picture."""


@dataclass(frozen=True, eq=False)
class Choice:
    """The settings that were chosen, their picture, and how far it is from the reference where that was looked at."""

    measured: Measured
    error: float
    """RMSE in linear RGB over `checked` pixels that the search has not seen."""
    checked: int
    checked_against: str
    """How those pixels were traced, and how far that is from converged."""
    candidates: tuple[Candidate, ...]
    """All that were considered, with what was foretold of them on `checked` other pixels."""

    @property
    def settings(self) -> Settings:
        return self.measured.settings


def measure(scene: Scene, camera: AbstractCamera, settings: Settings) -> Measured:
    """Render a scene with settings: the image of `render(scene, camera, **settings.options())`, its rays and its time.

    Raises `SceneError` for float64 where JAX is not set up for it, and `CapacityError` as `render` does.
    """
    return _whole(Tracer(in_precision(scene, settings.precision), camera), settings)


def choose(
    scene: Scene,
    camera: AbstractCamera,
    *,
    tolerance: float | None = None,
    time_budget: float | None = None,
    on_work: Callable[[str], None] | None = None,
) -> Choice:
    """The cheapest settings whose error is within `tolerance`, or the most accurate that take `time_budget` seconds
    or less.

    - `tolerance`: largest RMSE in linear RGB, against a far more accurate reference: more depth, more trees.
    - `time_budget`: for the picture, its program compiled.
    - `on_work`: called with what is being done.

    One of the two. The search goes over the settings of `KNOBS` in the precision of the scene, on 4096 pixels; the
    picture of what it finds is then checked on 4096 others, and if it fails there the next more accurate is tried.
    Raises `InputError` for a bound that is not positive, and where no settings meet it (it says what can be met), or
    within `jit`.
    """
    bound = _bound(tolerance, time_budget)
    if any(map(is_traced, jax.tree.leaves((scene, camera)))):
        raise InputError(
            "choose: the values of the scene or camera are traced, so there is nothing to measure; call it "
            "outside jit, grad or vmap"
        )
    say = on_work or (lambda text: None)
    search, check = _parts(camera.width * camera.height)
    whole = Tracer(scene, camera)
    part = whole if len(whole.all_pixels) <= 2 * PART else Tracer(scene, camera, pass_of=PART)
    say("tracing some pixels at reference quality")
    goal = bound / 5 if tolerance is not None else GOAL
    pixels = np.union1d(search, check)
    truth = reference(whole, pixels, lambda refined: goal)
    picture = dict(zip(pixels, truth.pixels, strict=True))
    at = {name: np.stack([picture[p] for p in which]) for name, which in (("search", search), ("check", check))}
    candidates = survey(part, at["search"], search, on_setting=lambda s: say(f"trying {s}"))

    def trial(settings: Settings) -> tuple[Measured, float]:
        say(f"rendering with {settings}")
        found = _whole(whole, settings)
        return found, rmse(found.image.reshape(-1, 3)[check], at["check"])

    ends = (
        _for_tolerance(candidates, bound, trial)
        if tolerance is not None
        else _for_budget(candidates, bound, trial, len(whole.all_pixels) / len(search))
    )
    return Choice(*ends, len(check), _stated(truth), candidates)


Trial = Callable[[Settings], tuple[Measured, float]]


def _for_tolerance(candidates: Sequence[Candidate], tolerance: float, trial: Trial) -> tuple[Measured, float]:
    """Where the check fails, what was foretold is too low by so much; the next choice counts with it."""
    wanted, reached = MARGIN * tolerance, np.inf
    least = min(candidates, key=lambda c: c.error)
    for number in range(MOST_TRIALS):
        found = (cheapest(candidates, wanted) if number < MOST_TRIALS - 1 else None) or least
        measured, error = trial(found.settings)
        if error <= tolerance:
            return measured, error
        reached = min(reached, error)
        if found is least:
            break
        wanted = min(0.999 * found.error, MARGIN * tolerance * found.error / error)
    raise InputError(
        f"tolerance = {tolerance:.3g}: no settings of the table are so accurate here; {least.settings} reaches "
        f"{reached:.2g}, so ask for {1.2 * reached:.2g} or more"
    )


def _for_budget(candidates: Sequence[Candidate], budget: float, trial: Trial, scale: float) -> tuple[Measured, float]:
    """The time foretold is corrected by what the last trial took."""
    best, tried = None, set()
    for _ in range(MOST_TRIALS):
        fitting = [c for c in candidates if c.seconds * scale <= budget and c.settings not in tried]
        if best is not None:
            fitting = [c for c in fitting if c.error < best[1]]
        if not fitting and best is None and not tried:
            fitting = candidates[:1]
        if not fitting:
            break
        found = min(fitting, key=lambda c: c.error)
        measured, error = trial(found.settings)
        tried.add(found.settings)
        scale = measured.seconds / found.seconds
        if measured.seconds <= budget and (best is None or error < best[1]):
            best = measured, error
    if best is None:
        least = min(candidates, key=lambda c: c.seconds)
        measured, _ = trial(least.settings)
        raise InputError(
            f"time budget of {budget:.3g} s: the cheapest settings of the table, {least.settings}, take "
            f"{measured.seconds:.2g} s here; allow more, or ask for a smaller picture"
        )
    return best


def _whole(tracer: Tracer, settings: Settings) -> Measured:
    """The whole picture: traced once for its program, then for its time, which is the median of some runs."""
    found, runs = tracer.trace(settings), []
    while not runs or (len(runs) < RUNS and sum(runs) < RUNS_SECONDS):
        runs.append(tracer.trace(settings).seconds)
    image = found.pixels.reshape(tracer.camera.height, tracer.camera.width, 3).astype(tracer.scene.dtype)
    return Measured(settings, image, found.rays, float(np.median(runs)), tracer.seconds_compile)


def in_precision(scene: Scene, precision: str) -> Scene:
    """The scene with all its numbers in this precision."""
    dtype = float_dtype(precision)
    cast = in_dtype(scene, dtype)
    if dtype != np.float32 or not any(camera.is_far for camera in scene.cameras.values()):
        return cast
    placed = {part: getattr(scene, part) for part in ("objects", "lights", "cameras", "textures")}
    return changed(cast, keeps_digits=True, **placed)


def _parts(pixels: int) -> tuple[np.ndarray, np.ndarray]:
    """Pixels for the search and others for the check, in turns."""
    chosen = spread_pixels(pixels, 2 * PART)
    return (chosen[::2], chosen[1::2]) if len(chosen) > 1 else (chosen, chosen)


def spread_pixels(pixels: int, most: int) -> np.ndarray:
    """Numbers of pixels spread evenly over all of them, one at random in each stretch of the same length; all if they
    are few.
    """
    count = min(most, pixels)
    first = np.arange(count) * pixels // count
    return first + np.random.default_rng(SEED).integers(0, pixels // count, count)


def _bound(tolerance: float | None, time_budget: float | None) -> float:
    if (tolerance is None) == (time_budget is None):
        raise InputError("choose: give a tolerance or a time budget, one of the two")
    name, value = ("tolerance", tolerance) if tolerance is not None else ("time budget", time_budget)
    try:
        bound = np.nan if value is None else float(value)
    except (TypeError, ValueError):
        bound = np.nan
    if not (isfinite(bound) and bound > 0):
        raise InputError(
            f"{name} = {value!r}; allowed is a number above 0, such as "
            f"{'1/255' if name == 'tolerance' else '0.1 (seconds)'}"
        )
    return bound


def _stated(truth: Reference) -> str:
    return f"{truth}; a quarter of the trees differs by {truth.difference:.1g}"
