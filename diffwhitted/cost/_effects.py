"""What each effect costs: the same picture without it, compiled and run in turns with all others."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from ..rendering._passes import trace_samples
from ..scene import AbstractCamera, Scene
from ..tree import Plan, effect_rows, tables_of
from ._programs import Program, compiled, share_without, timed
from ._work import Work, work_of, work_programs


@dataclass(frozen=True)
class EffectCost:
    """What a picture gains without one effect; what is below 0 costs more without it.

    Shares overlap, so they need not add up to 1: without refraction there is no total reflection either.
    """

    share: float
    """1 - (time without it) / (time with it)."""
    below_noise: bool
    """The share cannot be told from nothing."""
    compile_share: float
    """The same of the processor time to compile, from one run."""
    rays: int
    """How many fewer the picture takes without it; 0 for an effect that bends or ends no ray."""


@dataclass(frozen=True)
class PictureCost:
    """What a picture costs, in all and by its effects."""

    seconds: float
    """To trace it once, compiled: the median of some runs."""
    seconds_compile: float
    """Processor seconds."""
    rays: int
    """Of all samples, without shadow rays."""
    effects: dict[str, EffectCost]
    work: Work


def picture_cost(
    scene: Scene, camera: AbstractCamera, plan: Plan, on: Collection[str], say: Callable[[str], None]
) -> PictureCost:
    """Measure the picture, the picture without each effect of `on`, and the parts of its work."""
    say("the whole picture")
    _picture(scene, camera, plan)  # what JAX traces and compiles for all of them is there from now on
    pictures, rays = {}, {}
    pictures[""], rays[""] = _picture(scene, camera, plan)
    for name in on:
        say(f"the picture without {name.replace('_', ' ')}")
        changed, cut = _without(scene, plan, name)
        pictures[name], rays[name] = _picture(changed, camera, cut)
    say("its parts")
    seconds = timed(pictures | work_programs(scene, camera, plan))
    whole, search, walk = (seconds.pop(name) for name in ("", "search", "walk"))
    effects = {
        name: EffectCost(
            *share_without(whole, less),
            1 - pictures[name].seconds_compile / pictures[""].seconds_compile,
            rays[""] - rays[name],
        )
        for name, less in seconds.items()
    }
    return PictureCost(
        float(np.median(whole)), pictures[""].seconds_compile, rays[""], effects, work_of(whole, search, walk)
    )


def _picture(scene: Scene, camera: AbstractCamera, plan: Plan) -> tuple[Program, int]:
    """The picture as `render` traces it, with room for its rays, and how many they are."""
    tables, plan = tables_of(scene, plan), plan.program
    inputs = [(tables, number) for number in jnp.arange(plan.passes, dtype=jnp.int32)]
    while True:
        program = compiled(lambda given, plan=plan: trace_samples(given[0], camera, plan, given[1], 1), inputs)
        descendants = np.asarray([needed for _, needed in program.run()], np.int64)
        if descendants.max() <= plan.capacity:
            return program, camera.width * camera.height * plan.side**2 + int(descendants.sum())
        plan = plan.with_capacity(2 * int(descendants.max()))


def _without(scene: Scene, plan: Plan, effect: str) -> tuple[Scene, Plan]:
    """Scene and plan with one effect switched off, and with it those that cannot do without."""
    effects = plan.effects.without(effect)
    for row in effect_rows():
        if row.name in plan.effects and row.name not in effects:
            scene = row.without(scene)
    footprint = plan.footprint if "footprint" in effects else 0
    capacity = plan.capacity if effects.branching or footprint else 0
    return scene, replace(plan, effects=effects, footprint=footprint, capacity=capacity)
