"""What accuracy costs in a fit: the true coefficients of a scene looked for with settings of the table of knobs."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax.numpy as jnp
import numpy as np

from diffwhitted import Scene, decide_effects
from diffwhitted.accuracy._survey import front

from .._errors import FitError
from .._fit import fit
from .._result import FitResult, FittedCoefficient
from ..problem._bounds import Bounds
from ..problem._free_names import free_parameters, whole_names
from ..problem._target import Target, as_targets
from ..problem._unknowns import Unknown, list_unknowns, start_values, values_in
from ._fit_knobs import COMBINATIONS, FIT_KNOBS, FitKnob, FitSettings
from ._tradeoff import COMBINATION, OnWork, seconds_text

NEARLY = 2.0
"""A fit whose largest error is so many times the smallest, or less, is as good as the best."""
MOST_ROUNDS, ROUNDS_SECONDS = 5, 30.0


@dataclass(frozen=True)
class CoefficientError:
    """How far one fitted number is from the truth."""

    name: str
    truth: float
    value: float
    error: float
    """Not less than 0, in the unit of the coefficient."""
    of_bounds: float
    """Share of the width of its bounds, in the scale in which the fit looks for it: the logarithm for an exponent."""
    of_interval: float | None
    """Distance of the truth from the value, 1 at the end of the 95 % interval on its side; None without one."""


@dataclass(frozen=True)
class FitPoint:
    """One setting, and the fit with it."""

    settings: FitSettings
    sweeps: tuple[str, ...]
    """The knobs in whose sweep it lies, or "combination"."""
    status: str
    steps: int
    seconds: float
    """A whole fit with its programs compiled: the median of runs that took turns with those of all other settings."""
    coefficients: tuple[CoefficientError, ...]
    on_front: bool = False
    """It converged, and no other that did has a smaller largest error in less time."""

    @property
    def worst(self) -> CoefficientError:
        return max(self.coefficients, key=lambda c: c.of_bounds)

    @property
    def largest(self) -> float:
        """The largest error, as a share of the bounds."""
        return self.worst.of_bounds

    @property
    def converged(self) -> bool:
        return self.status == "converged"

    @property
    def covered(self) -> int:
        """How many of the 95 % intervals hold the truth."""
        return sum(c.of_interval is not None and c.of_interval <= 1 for c in self.coefficients)


@dataclass(frozen=True)
class FitTradeoff:
    """Fits with their errors and times, cheapest first."""

    width: int
    height: int
    points: tuple[FitPoint, ...]
    default: FitSettings
    """What `fitting.fit` takes for this scene."""
    start: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]
    rounds: int
    seconds_compile: float
    """Of the first runs, what they took beyond the later ones."""

    @property
    def recommended(self) -> FitPoint | None:
        """The cheapest that converged and is nearly as good as the best."""
        found = [p for p in self.points if p.converged]
        least = min((p.largest for p in found), default=0.0)
        return next((p for p in found if p.largest <= NEARLY * least), None)

    def to_json(self) -> dict[str, Any]:
        """Everything as JSON values."""
        chosen, knobs = self.recommended, self.default.knobs
        truth = {c.name: c.truth for c in self.points[0].coefficients}
        return {
            "free": list(self.start),
            "truth": truth,
            "start": dict(self.start),
            "bounds": {n: list(b) for n, b in self.bounds.items()},
            "knobs": [
                {"name": k.name, "costs": k.costs, "controls": k.controls, "sweep": list(k.sweep)} for k in knobs
            ],
            "rounds": self.rounds,
            "seconds_compile": self.seconds_compile,
            "default": self.default.named(),
            "recommended": None if chosen is None else chosen.settings.named(),
            "sentence": recommendation(self),
            "points": [
                {
                    "settings": p.settings.named(),
                    "text": str(p.settings),
                    "sweeps": list(p.sweeps),
                    "status": p.status,
                    "steps": p.steps,
                    "seconds": p.seconds,
                    "largest": p.largest,
                    "largest_of": p.worst.name,
                    "on_front": p.on_front,
                    "coefficients": {
                        c.name: {
                            "value": c.value,
                            "error": c.error,
                            "of_bounds": c.of_bounds,
                            "of_interval": c.of_interval,
                        }
                        for c in p.coefficients
                    },
                }
                for p in self.points
            ],
        }


def tradeoff_of_fits(
    scene: Scene,
    target: Target,
    free: Sequence[str],
    *,
    start: Mapping[str, float] | None = None,
    knobs: Sequence[FitKnob] = FIT_KNOBS,
    combinations: Sequence[Mapping[str, Any]] = COMBINATIONS,
    on_work: OnWork | None = None,
) -> FitTradeoff:
    """Fit the free coefficients of a scene, whose values are the truth, to the target that those would give.

    - `target`: what the scene looks like in truth, such as its reference.
    - `start`: by name, with wildcards; all others start from the middle of their bounds, in their own scale.
    - `knobs`, `combinations`: each knob is swept alone from what `fit` uses by default.

    A depth at which a free coefficient would have no effect is left out. Raises `FitError` as `fit` does.
    """
    work = on_work or (lambda text, done: None)
    names, _ = free_parameters(scene, free)
    unknowns = list_unknowns(scene, names)
    first = start_values(scene, unknowns, {**_middle(unknowns), **(start or {})})
    begin = {u.name: float(value) for u, value in zip(unknowns, first, strict=True)}
    default = FitSettings.of(scene, any(u.moves for u in unknowns), knobs)
    height, width = as_targets(scene, target)[0].mask.shape
    programs = _programs(scene, names, default, combinations, height * width)

    def run(settings: FitSettings) -> tuple[FitResult, float]:
        begun = time.perf_counter()
        result = fit(scene.with_cutoff(settings["cutoff"]), target, names, start=begin, **settings.arguments())
        if result.status == "interrupted":
            raise KeyboardInterrupt
        return result, time.perf_counter() - begun

    points, rounds, compiling = _measured(programs, run, _truth(scene, unknowns), unknowns, work)
    return FitTradeoff(width, height, points, default, begin, {u.name: u.bounds for u in unknowns}, rounds, compiling)


def _middle(unknowns: tuple[Unknown, ...]) -> dict[str, float]:
    """Of their bounds, where the unknown of `Bounds` is a quarter of pi."""
    values = Bounds(unknowns).values(jnp.full(len(unknowns), np.pi / 4))
    return {u.name: float(value) for u, value in zip(unknowns, values, strict=True)}


def _truth(scene: Scene, unknowns: tuple[Unknown, ...]) -> np.ndarray:
    return values_in(scene, unknowns, scene)


def _programs(
    scene: Scene, names: tuple[str, ...], default: FitSettings, combinations, pixels: int
) -> dict[FitSettings, list[str]]:
    """The settings to measure, and the sweeps that each lies in."""
    effects = {d.name: d.on for d in decide_effects(scene, whole_names(scene, names))}
    branching, found = effects["reflection"] or effects["refraction"], {default: []}
    swept = [knob for knob in default.knobs if (branching or knob.group != "tree") and pixels >= knob.least_pixels]
    for knob in swept:
        for value in knob.sweep:
            found.setdefault(default.only(**{knob.name: value}), []).append(knob.name)
    for values in combinations:
        if set(values) <= {knob.name for knob in swept}:
            found.setdefault(default.only(**values), [])
    return {
        settings: sweeps or [COMBINATION]
        for settings, sweeps in found.items()
        if _have_effect(scene, names, settings["depth"])
    }


def _have_effect(scene: Scene, names: tuple[str, ...], depth: int) -> bool:
    """Would all of these coefficients change a picture of this depth?"""
    try:
        return free_parameters(scene, names, depth)[0] == names
    except FitError:
        return False


def _measured(
    programs: dict[FitSettings, list[str]],
    run: Callable[[FitSettings], tuple[FitResult, float]],
    truth: np.ndarray,
    unknowns: tuple[Unknown, ...],
    work: OnWork,
) -> tuple[tuple[FitPoint, ...], int, float]:
    """Every fit once for its programs and its result, then in turns for its time."""
    points, first, runs = {}, {}, {settings: [] for settings in programs}
    for number, (settings, sweeps) in enumerate(programs.items()):
        work(f"fitting with {settings}", 0.7 * number / len(programs))
        result, first[settings] = run(settings)
        points[settings] = FitPoint(
            settings, tuple(sweeps), result.status, result.steps, 0.0, _errors(result.coefficients, truth, unknowns)
        )
    rounds, number = MOST_ROUNDS, 0
    while number < rounds:
        begun = time.perf_counter()
        for place, (settings, seconds) in enumerate(runs.items()):
            work(
                f"timing all fits in turns, round {number + 1} of {rounds}",
                0.7 + 0.3 * (number + place / len(runs)) / rounds,
            )
            seconds.append(run(settings)[1])
        number += 1
        if number == 1:
            rounds = int(np.clip(ROUNDS_SECONDS / (time.perf_counter() - begun), 1, MOST_ROUNDS))
    timed = sorted(
        (replace(p, seconds=float(np.median(runs[s]))) for s, p in points.items()), key=lambda p: (p.seconds, p.largest)
    )
    compiling = sum(max(first[p.settings] - p.seconds, 0.0) for p in timed)
    marked = dict(
        zip(
            (p for p in timed if p.converged),
            front([p for p in timed if p.converged], error=lambda p: p.largest),
            strict=True,
        )
    )
    return tuple(replace(p, on_front=marked.get(p, False)) for p in timed), rounds, compiling


def _errors(
    coefficients: Sequence[FittedCoefficient], truth: np.ndarray, unknowns: tuple[Unknown, ...]
) -> tuple[CoefficientError, ...]:
    bounds, values = Bounds(unknowns), np.asarray([c.value for c in coefficients])
    shares = [np.asarray(bounds.shares(jnp.clip(jnp.asarray(v), bounds.low, bounds.high))) for v in (values, truth)]
    return tuple(
        CoefficientError(
            c.name, float(true), c.value, abs(c.value - float(true)), float(share), _of_interval(c, float(true))
        )
        for c, true, share in zip(coefficients, truth, abs(shares[0] - shares[1]), strict=True)
    )


def _of_interval(coefficient: FittedCoefficient, truth: float) -> float | None:
    if coefficient.interval_95 is None:
        return None
    reach = abs(coefficient.interval_95[truth > coefficient.value] - coefficient.value)
    error = abs(truth - coefficient.value)
    return 0.0 if error == 0 else error / reach if reach else None


def recommendation(found: FitTradeoff) -> str:
    """One sentence: the settings to fit with, and what the defaults give."""
    chosen = found.recommended
    if chosen is None:
        return "For a fit: none converged with every coefficient determined; free fewer, or show them in another view."
    text = f"For a fit: {chosen.settings}: {seconds_text(chosen.seconds)}, largest error {_largest(chosen)}"
    if chosen.settings == found.default:
        return f"{text}; these are the defaults of fit."
    own = next(p for p in found.points if p.settings == found.default)
    how = "" if own.converged else f", and says itself that it is {own.status.replace('_', ' ')}"
    return f"{text}; the default, {own.settings}, takes {seconds_text(own.seconds)} and errs by {_largest(own)}{how}."


def _largest(point: FitPoint) -> str:
    return f"{point.largest:.2g} of the bounds ({point.worst.name})"
