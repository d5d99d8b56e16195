"""What the settings of the table give on some pixels of a scene: a few traced, the others foretold from them."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace

import jax
import numpy as np

from ._blur import blurs
from ._knobs import KNOBS, Knob, Settings
from ._lamps import has_sized_lights
from ._materials import has_fresnel, has_gloss
from ._reference import rmse
from ._tracer import Traced, Tracer

ROUNDS = 3


@dataclass(frozen=True)
class Candidate:
    """Settings with their error on the surveyed pixels (RMSE, linear RGB), their rays and their seconds there."""

    settings: Settings
    error: float
    rays: float
    seconds: float


def base_settings(tracer: Tracer) -> Settings:
    """Where the sweeps start: what the scene asks for, each pixel one filtered tree."""
    return Settings.of(tracer.scene).only(footprint=max(tracer.scene.footprint, 1))


def swept_knobs(tracer: Tracer) -> list[Knob]:
    """The knobs that change anything here."""
    idle = {
        "tree": not tracer.branches,
        "arithmetic": not jax.config.jax_enable_x64,  # pyright: ignore[reportAttributeAccessIssue]
        "light": not has_sized_lights(tracer.scene),
        "fresnel": not has_fresnel(tracer.scene),
        "gloss": not has_gloss(tracer.scene),
        "blur": not blurs(tracer.camera),
        "mesh": all(thing.interpolation in (None, "flat") for thing in tracer.scene.objects),
    }
    return [knob for knob in KNOBS if not idle.get(knob.group)]


def sweeps(tracer: Tracer, base: Settings) -> dict[str, tuple[Settings, ...]]:
    """By group, the settings that differ from `base` in the knobs of that group; `base` alone where they change
    nothing.
    """
    return {"pixel": base.alternatives("pixel"), "tree": base.alternatives("tree") if tracer.branches else (base,)}


def survey(
    tracer: Tracer,
    truth: np.ndarray,
    pixels: np.ndarray,
    rounds: int = ROUNDS,
    on_setting: Callable[[Settings], None] | None = None,
) -> tuple[Candidate, ...]:
    """All settings of the table, cheapest first.

    Traced are those that differ from the base in one group alone. What two groups do together is nearly the sum of what
    each does, pixel by pixel, and the product of what each costs; so the others are foretold. Rays of one way
    to sample a pixel take the same time, which is measured.
    """
    base = base_settings(tracer)
    groups, found = sweeps(tracer, base), {}
    for settings in dict.fromkeys(settings for group in groups.values() for settings in group):
        if on_setting is not None:
            on_setting(settings)
        found[settings] = tracer.trace(settings, pixels)
    pace = _pace(tracer, found.values(), pixels, rounds)
    foretold = {}
    for tree in groups["tree"]:
        for pixel in groups["pixel"]:
            settings = tree.with_group(pixel, "pixel")
            picture = found[pixel].pixels + (found[tree].pixels - found[base].pixels)
            rays = found[pixel].rays * found[tree].rays / found[base].rays
            foretold[settings] = Candidate(settings, rmse(picture, truth), rays, rays * pace[settings.way])
    for settings, traced in found.items():
        foretold[settings] = replace(foretold[settings], error=rmse(traced.pixels, truth))
    return tuple(sorted(_without_idle(foretold.values()), key=lambda c: c.seconds))


def cheapest(candidates: Sequence[Candidate], tolerance: float) -> Candidate | None:
    """The first of the candidates, cheapest first, that is within the tolerance."""
    return next((c for c in candidates if c.error <= tolerance), None)


def front(points: Sequence, cost: Callable = lambda p: p.seconds, error: Callable = lambda p: p.error) -> list[bool]:
    """Which points are on the Pareto front: no other is at least as good in both and better in one."""
    order = sorted(range(len(points)), key=lambda i: (cost(points[i]), error(points[i])))
    marked, best, best_cost = [False] * len(points), np.inf, -np.inf
    for i in order:
        here = error(points[i])
        marked[i] = here < best or (here == best and cost(points[i]) == best_cost)
        if here < best:
            best, best_cost = here, cost(points[i])
    return marked


def _pace(tracer: Tracer, found: Collection[Traced], pixels: np.ndarray, rounds: int) -> dict[str, float]:
    """Seconds a ray for each way to sample a pixel: the median of some runs of its second cheapest settings."""
    pace = {}
    for way in {traced.settings.way for traced in found}:
        some = sorted((traced for traced in found if traced.settings.way == way), key=lambda t: t.rays)[:2][-1].settings
        runs = [tracer.trace(some, pixels) for _ in range(rounds)]
        pace[way] = float(np.median([run.seconds / run.rays for run in runs]))
    return pace


def _without_idle(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Of several depths that trace the same rays to the same picture, the smallest; so too for the cutoff."""
    kept: dict[tuple, Candidate] = {}
    for one in sorted(candidates, key=lambda c: [c.settings.depth, c.settings.cutoff]):
        pixel = tuple(one.settings[knob] for knob in KNOBS if knob.group != "tree")
        kept.setdefault((*pixel, one.rays, one.error), one)
    return list(kept.values())
