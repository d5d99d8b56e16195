"""What accuracy costs in time for one scene: settings of the table of knobs, measured against a reference."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from diffwhitted import KNOBS, InputError, Scene, Settings
from diffwhitted.accuracy._choose import MARGIN, in_precision, spread_pixels
from diffwhitted.accuracy._reference import Reference, converged_settings, reference, rmse
from diffwhitted.accuracy._survey import Candidate, base_settings, cheapest, front, survey, swept_knobs
from diffwhitted.accuracy._tracer import Tracer
from diffwhitted.scene import AbstractCamera, whole_number

CONVERGED = 0.1
"""Of the smallest error: two references that differ by less tell the errors apart."""
STEP = 0.8
"""A combination is measured if it is foretold to have so large a part of the error of the one before, or less."""
FEWEST_ROUNDS, MOST_ROUNDS, ROUNDS_SECONDS = 5, 15, 20.0
SURVEYED = 2**16
COMBINATION = "combination"
OnWork = Callable[[str, float], None]
"""Called with what is being done, and the part of all work that is done."""


@dataclass(frozen=True)
class Point:
    """One setting, measured on the whole picture."""

    settings: Settings
    sweeps: tuple[str, ...]
    """The knobs in whose sweep it lies, or "combination"."""
    rmse: float
    """Linear RGB, as `largest`, the error of the worst channel of the worst pixel."""
    largest: float
    ciede2000_mean: float
    """In display space, as `ciede2000_p95`, its 95th percentile over the pixels."""
    ciede2000_p95: float
    rays: int
    seconds: float
    """The median of runs that took turns with those of all other settings."""
    bound: float | None
    """No channel of a pixel would be brighter by more if its own samples were followed to depth 64 with no cutoff
    (`Tracer.left_out`), in linear RGB. None where no such bound is known, infinite where it is not finite. What lies
    between samples is not in it.
    """
    on_front: bool = False
    """No other setting measured here has a smaller RMSE in less time."""


@dataclass(frozen=True)
class Tradeoff:
    """Settings with their errors and times, cheapest first."""

    width: int
    height: int
    points: tuple[Point, ...]
    asked: Settings
    """What `diffwhitted.render` takes for this scene."""
    tolerance: float
    reference: str
    reference_difference: float
    """RMSE of two references, the better of which is the truth here."""
    rounds: int
    seconds_compile: float
    picture: np.ndarray = field(repr=False, compare=False)
    """(height, width, 3), linear RGB: the reference."""

    @property
    def smallest_error(self) -> float:
        return min(point.rmse for point in self.points)

    @property
    def converged(self) -> bool:
        return self.reference_difference <= CONVERGED * self.smallest_error

    @property
    def recommended(self) -> Point | None:
        """The cheapest within the tolerance."""
        return next((p for p in self.points if p.rmse <= self.tolerance), None)

    def to_json(self) -> dict[str, Any]:
        """Everything as JSON values, with the table of knobs and the sentences."""
        knobs = [
            {"name": k.name, "costs": k.costs, "controls": k.controls, "default": k.default, "sweep": list(k.sweep)}
            for k in KNOBS
        ]
        chosen = self.recommended
        return {
            "width": self.width,
            "height": self.height,
            "tolerance": self.tolerance,
            "knobs": knobs,
            "reference": {"text": self.reference, "difference": self.reference_difference, "converged": self.converged},
            "rounds": self.rounds,
            "seconds_compile": self.seconds_compile,
            "asked": asdict(self.asked),
            "recommended": None if chosen is None else asdict(chosen.settings),
            "sentences": list(sentences(self)),
            "points": [
                asdict(p) | {"text": str(p.settings), "sweeps": list(p.sweeps), "bound": bound_value(p.bound)}
                for p in self.points
            ],
        }


def tradeoff(
    scene: Scene,
    camera: AbstractCamera,
    tolerance: float = 1 / 255,
    on_work: OnWork | None = None,
    rounds: int | None = None,
) -> Tradeoff:
    """Sweep the knobs, each alone from what the scene asks for with one filtered tree a pixel, and their useful
    combinations.

    A combination is useful if a survey foretells that no other is better in both error and time, and that it is at
    least a fifth more accurate than the last cheaper one. The reference is refined until it is certain to a tenth of
    the smallest error, or as far as it goes. Each setting is timed in so many `rounds`; by default in 5 to 15, by
    what the machine does in about 20 s. Raises `InputError` for a tolerance that is not above 0 or rounds that are no
    whole number, and `CapacityError` as `render` does.
    """
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise InputError(f"tolerance = {tolerance!r}; allowed is a number above 0, such as 1/255")
    rounds = None if rounds is None else whole_number(rounds, "rounds", error=InputError)
    work = on_work or (lambda text, done: None)
    tracer, asked = Tracer(scene, camera), Settings.of(scene)
    work("compiling; less to do next time", 0.0)
    accurate = [tracer.trace(settings).pixels for settings in _most_accurate(tracer)]
    truth = reference(
        tracer,
        None,
        lambda refined: CONVERGED * min(rmse(a, refined) for a in accurate),
        lambda done: work("tracing the reference", 0.15 + 0.45 * done),
        converged_settings(tracer),
    )
    work("looking for useful combinations", 0.6)
    some = spread_pixels(camera.width * camera.height, SURVEYED)
    candidates = survey(tracer, truth.pixels[some], some)
    tracers, programs = {scene.precision: tracer}, _programs(tracer, asked, candidates, tolerance)
    points, rounds = _measured(tracers, programs, truth, camera, work, rounds)
    compiling = sum(t.seconds_compile for t in tracers.values())
    picture = truth.pixels.reshape(camera.height, camera.width, 3)
    return Tradeoff(
        camera.width, camera.height, points, asked, tolerance, str(truth), truth.difference, rounds, compiling, picture
    )


def _most_accurate(tracer: Tracer) -> list[Settings]:
    """The most points and the most trees a pixel, as deep as the sweep goes. Dividing pixels does not go so far."""
    finest = "depth", "light_samples", "fresnel", "roughness_samples"
    deep = {knob.name: knob.sweep[-1] for knob in swept_knobs(tracer) if knob.name in finest}
    base = replace(base_settings(tracer), cutoff=0.0, **deep)
    return [base.only(**{knob.name: knob.sweep[-1]}) for knob in KNOBS if knob.name in ("samples", "footprint")]


def _programs(
    tracer: Tracer, asked: Settings, candidates: Sequence[Candidate], tolerance: float
) -> dict[Settings, list[str]]:
    """The settings to measure, and the sweeps that each lies in."""
    base, found = base_settings(tracer), {asked: []}
    for knob in swept_knobs(tracer):
        for settings in base.alone(knob):
            found.setdefault(settings, []).append(knob.name)
    last = np.inf
    wanted = cheapest(candidates, MARGIN * tolerance)
    for candidate, best in zip(candidates, front(candidates), strict=True):
        if candidate is wanted or (best and candidate.error <= STEP * last):
            found.setdefault(candidate.settings, [])
            last = candidate.error
    return {settings: sweeps or [COMBINATION] for settings, sweeps in found.items()}


def steps_that_count(points: Sequence, error: Callable[[Any], float]) -> list:
    """Of points of falling error those that are at least a fifth more accurate than the one kept before."""
    kept = []
    for point in points:
        if not kept or error(point) <= STEP * error(kept[-1]):
            kept.append(point)
    return kept


def _measured(
    tracers: dict[str, Tracer],
    programs: dict[Settings, list[str]],
    truth: Reference,
    camera: AbstractCamera,
    work: OnWork,
    rounds: int | None,
) -> tuple[tuple[Point, ...], int]:
    """Every setting once for its picture, then in turns for its time."""
    (tracer,) = tracers.values()
    points, runs = {}, {settings: [] for settings in programs}
    for number, (settings, sweeps) in enumerate(programs.items()):
        work(f"measuring {settings}", 0.65 + 0.15 * number / len(programs))
        if settings.precision not in tracers:
            tracers[settings.precision] = Tracer(in_precision(tracer.scene, settings.precision), camera)
        found, beyond = tracers[settings.precision].trace(settings), tracers[settings.precision].left_out(settings)
        bound = None if beyond is None else float(beyond.max())
        points[settings] = Point(
            settings, tuple(sweeps), *_errors(found.pixels, truth.pixels, camera), found.rays, found.seconds, bound
        )
    once = sum(point.seconds for point in points.values())
    rounds = rounds or int(np.clip(ROUNDS_SECONDS / once, FEWEST_ROUNDS, MOST_ROUNDS))
    for number in range(rounds):
        work(f"timing all settings in turns, round {number + 1} of {rounds}", 0.8 + 0.2 * number / rounds)
        for settings, seconds in runs.items():
            seconds.append(tracers[settings.precision].trace(settings).seconds)
    timed = sorted(
        (replace(p, seconds=float(np.median(runs[s]))) for s, p in points.items()), key=lambda p: (p.seconds, p.rmse)
    )
    marks = front(timed, error=lambda p: p.rmse)
    return tuple(replace(p, on_front=mark) for p, mark in zip(timed, marks, strict=True)), rounds


def _errors(pixels: np.ndarray, truth: np.ndarray, camera: AbstractCamera) -> tuple[float, float, float, float]:
    """RMSE and largest in linear RGB; mean and 95th percentile of CIEDE2000 as a display shows them."""
    from diffwhitted.image import ciede2000

    shape = camera.height, camera.width, 3
    seen = ciede2000(pixels.reshape(shape), truth.reshape(shape))
    return rmse(pixels, truth), float(np.abs(pixels - truth).max()), float(seen.mean()), float(np.percentile(seen, 95))


def sentences(found: Tradeoff) -> tuple[str, str, str]:
    """The recommendation, what the scene's own settings give, and how far the reference can be trusted."""
    return recommendation(found), _own(found), convergence(found)


def recommendation(found: Tradeoff) -> str:
    chosen, wanted = found.recommended, tolerance_text(found.tolerance)
    if chosen is None:
        best = min(found.points, key=lambda p: p.rmse)
        return (
            f"For {wanted}: no setting is so accurate here; the nearest is {best.settings}: error "
            f"{best.rmse:.3g}, {seconds_text(best.seconds)}."
        )
    text = f"For {wanted}: {chosen.settings}: {seconds_text(chosen.seconds)}, error {chosen.rmse:.3g}"
    step = next((p for p in found.points if p.on_front and p.rmse <= STEP * chosen.rmse), None)
    if step is None:
        return f"{text}. No setting here is more accurate by a fifth or more."
    return (
        f"{text}; the next step down in error, {step.settings} with {step.rmse:.3g}, costs "
        f"{step.seconds / chosen.seconds:.2g} times."
    )


def _own(found: Tradeoff) -> str:
    own = next(p for p in found.points if p.settings == found.asked)
    return f"The scene as it is, {own.settings}: error {own.rmse:.3g}, {seconds_text(own.seconds)}."


def convergence(found: Tradeoff) -> str:
    share = found.smallest_error / max(found.reference_difference, 1e-300)
    text = (
        f"Reference: {found.reference}. With a quarter of the trees it differs by "
        f"{found.reference_difference:.1g} (RMSE)"
    )
    if found.converged:
        return f"{text}, {'a thousandth or less' if share >= 1000 else f'1/{share:.0f}'} of the smallest error."
    return (
        f"{text}, more than a tenth of the smallest error, {found.smallest_error:.2g}: it has not converged, and "
        f"errors below {found.reference_difference / CONVERGED:.1g} are uncertain."
    )


def bound_value(bound: float | None) -> float | str | None:
    """For JSON and CSV: an infinite bound is "Infinity", which numbers in most languages can be read from."""
    return "Infinity" if bound == np.inf else bound


def bound_text(bound: float | None) -> str:
    return (
        "not bounded"
        if bound is None
        else "infinite"
        if bound == np.inf
        else f"{bound:.0f}"
        if 10 <= bound < 1e5
        else f"{bound:.2g}"
    )


def seconds_text(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1 else f"{1000 * seconds:.3g} ms"


def tolerance_text(tolerance: float) -> str:
    """1/255 for 0.00392..., the number where it is no such fraction."""
    whole = round(1 / tolerance)
    return f"1/{whole}" if whole > 1 and abs(whole * tolerance - 1) < 1e-9 else f"{tolerance:.3g}"
