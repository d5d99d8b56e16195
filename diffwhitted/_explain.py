"""What a picture is made of: which effects are at work and why, what each costs, and which rays there are."""

import os
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ._render import record_passes, render_passes, replay_passes
from .scene import Camera, ConstantBackground, DirectionalLight, GradientBackground, Material, PointLight, Scene, depth_number, split_name
from .tree import BRANCH_NAMES, Decision, Plan, Record, decide_effects, likely_room, make_plan

FEWEST_ROUNDS, MOST_ROUNDS = 5, 25
ROUNDS_SECONDS = 4.0
"""Every program is run once a round, for about so long in all."""
CERTAIN = 3.0
"""A share counts from this many of its standard errors on."""
SMALLEST_SHARE = 0.005


@dataclass(frozen=True)
class ExplainedEffect:
    """One effect: is it on, why, and what part of the time goes into it.

    `share` is 1 - (time without it) / (time with it), None where it was not measured; below 0 or
    `below_noise` it cannot be told from nothing. Shares overlap, so they need not add up to 1: without
    refraction there is no total reflection either.
    """

    name: str
    on: bool
    why: str
    share: float | None = None
    below_noise: bool = False


@dataclass(frozen=True)
class RayCounts:
    """How many rays one sample a pixel takes; `sum(by_level) == sum(by_kind.values()) == total`."""

    by_level: tuple[int, ...]
    """The first entry counts the camera rays, the last the deepest rays that there are."""
    by_kind: dict[str, int]
    """"camera", "mirror" (weighted by k_s), "transmitted" (k_t), "total" (total internal reflection), "past"
    (what an object's outline leaves of a pixel, where rays have a footprint)."""
    background: int
    """Of these, the rays that met nothing."""
    shadow: int
    """Beside these, the rays from lit points (N.L > 0) to lights; 0 where nothing casts shadows."""
    cut_off: dict[str, int]
    """The rays past `max_depth`, by kind: they return black and are not among those above."""

    @property
    def total(self) -> int:
        return sum(self.by_level)


@dataclass(frozen=True)
class Explanation:
    """What `explain` found out about a scene seen by a camera."""

    width: int
    height: int
    max_depth: int
    effects: tuple[ExplainedEffect, ...]
    rays: RayCounts
    seconds: float | None
    """To record and replay the picture once, compiled (the median); None where nothing was measured."""

    def to_json(self) -> dict[str, Any]:
        """Everything as JSON values."""
        content = asdict(self)
        content["rays"] = {"total": self.rays.total, **content["rays"], "by_level": list(self.rays.by_level)}
        return content | {"effects": list(content["effects"])}


def explain(scene: Scene, camera: Camera, *, free: Collection[str] = (), max_depth: int | None = None, measure: bool = True,
            on_measure: Callable[[str], None] | None = None) -> Explanation:
    """Every effect with its reason and its share of the time, and the rays by level and kind.

    - `free`: names of coefficients ("glass.k_s") that a fit leaves free: they keep their effect at 0.
    - `max_depth`: in place of the scene's.
    - `measure`: time the picture without each effect in turn. Each takes a program of its own to compile
      (seconds), so False gives reasons and rays much sooner.
    - `on_measure`: called with the name of each effect before its program is compiled.

    Raises `SceneError` for a free name that the scene does not have, and for a max_depth that is not one.
    """
    for name in free:
        split_name(scene, name)
    max_depth = depth_number(max_depth)
    rays, room = _counted(scene, camera, free, max_depth)
    plan = make_plan(scene, camera, free=free, max_depth=max_depth, capacity=room)
    decisions = decide_effects(scene, free, max_depth)
    shares, seconds = _measured(scene, camera, plan, decisions, on_measure) if measure else ({}, None)
    effects = tuple(ExplainedEffect(d.name, d.on, d.why, *shares.get(d.name, ())) for d in decisions)
    return Explanation(camera.width, camera.height, plan.max_depth, effects, rays, seconds)


def _counted(scene: Scene, camera: Camera, free: Collection[str], max_depth: int | None) -> tuple[RayCounts, int]:
    """The rays, and the room that a plan needs for them."""
    depth = scene.max_depth if max_depth is None else max_depth
    shadows = any(d.name == "shadows" and d.on for d in decide_effects(scene, free, depth))
    # One level more than asked for shows what the depth cuts off.
    plan = make_plan(scene, camera, free=free, max_depth=depth + 1, capacity=likely_room(camera))
    plan = replace(plan, effects=replace(plan.effects, shadows=False, tinted_shadows=False))
    while True:
        trees = record_passes(scene, camera, plan)
        needed = int(np.max(trees.descendants))
        if needed <= plan.capacity:
            break
        plan = plan.with_capacity(2 * needed)
    level = np.where(_are_rays(camera, plan, trees), np.asarray(trees.nodes.origin.level), 0)
    kind = np.asarray(trees.nodes.origin.branch)
    kept = (level > 0) & (level <= depth)
    counts = RayCounts(
        by_level=tuple(map(int, np.bincount(level[kept], minlength=2)[1:])), by_kind=_by_kind(kind[kept]),
        background=int((np.asarray(trees.nodes.object)[kept] < 0).sum()),
        shadow=_shadow_rays(scene, camera, plan, trees, kept) if shadows else 0,
        cut_off={name: count for name, count in _by_kind(kind[level > depth]).items() if name != "camera"},
    )
    return counts, int((kept & (level > 1)).sum(axis=1).max())


def _are_rays(camera: Camera, plan: Plan, trees: Record) -> np.ndarray:
    """Which slots (passes, slots) of recorded trees hold a ray: not those past the picture or past the tree's end."""
    slot = np.arange(plan.slots)
    pixel = np.arange(plan.passes)[:, None] + slot * plan.passes
    primary = (slot < plan.pass_pixels) & (pixel < camera.width * camera.height)
    end = plan.pass_pixels + np.asarray(trees.descendants)[:, None]
    return primary | ((slot >= plan.pass_pixels) & (slot < end))


def _by_kind(kind: np.ndarray) -> dict[str, int]:
    return dict(zip(BRANCH_NAMES, map(int, np.bincount(kind, minlength=len(BRANCH_NAMES))), strict=True))


def _without(scene: Scene, plan: Plan, effect: str) -> tuple[Scene, Plan]:
    """Scene and plan with one effect switched off, and with it those that cannot do without."""
    on = asdict(plan.effects) | {effect: False}
    lit, branching = on["diffuse"] or on["highlight"], on["reflection"] or on["refraction"]
    needs = {"shadows": lit, "attenuation": lit, "total_internal_reflection": on["refraction"], "nested_media": on["refraction"]}
    on |= {name: on[name] and need for name, need in needs.items()}
    on["tinted_shadows"] = on["tinted_shadows"] and on["shadows"]
    if not on["attenuation"]:
        bare = [PointLight(p.position, p.colour) if isinstance(p, PointLight) else p for p in scene.lights]
        scene = eqx.tree_at(lambda s: s.lights, scene, tuple(bare))
    if not on["background_gradient"] and isinstance(scene.background, GradientBackground):
        scene = eqx.tree_at(lambda s: s.background, scene, ConstantBackground(scene.background.top))
    mirrors = tuple(m and on["reflection"] for m in plan.mirrors)
    effects, footprint = replace(plan.effects, **on), plan.footprint if on["footprint"] else 0
    capacity = plan.capacity if branching or footprint else 0
    return scene, replace(plan, effects=effects, mirrors=mirrors, footprint=footprint, capacity=capacity)


def _measured(scene: Scene, camera: Camera, plan: Plan, decisions: Sequence[Decision],
             on_measure: Callable[[str], None] | None = None) -> tuple[dict[str, tuple[float, bool]], float]:
    """(share of the time, below noise) for each effect that is on, and the seconds of the whole picture.

    All programs take turns, so that a change of the machine's speed meets all of them; the share is the
    median over the rounds, its standard error comes from their median absolute deviation.
    """
    programs = {"": (scene, plan)} | {d.name: _without(scene, plan, d.name) for d in decisions if d.on}
    seconds = {name: [] for name in programs}
    _compile(programs, camera, on_measure)
    begun, rounds = time.perf_counter(), 0
    while rounds < FEWEST_ROUNDS or (rounds < MOST_ROUNDS and time.perf_counter() - begun < ROUNDS_SECONDS):
        for name, (changed, cut) in programs.items():
            start = time.perf_counter()
            jax.block_until_ready(render_passes(changed, camera, cut))
            seconds[name].append(time.perf_counter() - start)
        rounds += 1
    whole = np.asarray(seconds.pop(""))
    return {name: _share(whole, np.asarray(less)) for name, less in seconds.items()}, float(np.median(whole))


def _compile(programs: Mapping[str, tuple[Scene, Plan]], camera: Camera, on_measure: Callable[[str], None] | None) -> None:
    """Compile and run each program once, as many at a time as there are processors."""

    def run_once(name: str) -> None:
        if on_measure is not None and name:
            on_measure(name)
        scene, plan = programs[name]
        jax.block_until_ready(render_passes(scene, camera, plan))

    workers = ThreadPoolExecutor(os.cpu_count())
    try:
        for run in [workers.submit(run_once, name) for name in programs]:
            run.result()
    finally:
        workers.shutdown(wait=False, cancel_futures=True)


def _share(whole: np.ndarray, less: np.ndarray) -> tuple[float, bool]:
    shares = 1 - less / whole
    share = float(np.median(shares))
    # Of normally distributed values: standard deviation 1.48 MAD, standard error of the median 1.25 of the mean's.
    error = 1.25 * 1.48 * float(np.median(np.abs(shares - share))) / len(shares) ** 0.5
    return share, bool(share < max(CERTAIN * error, SMALLEST_SHARE))


def _shadow_rays(scene: Scene, camera: Camera, plan: Plan, trees: Record, counted: np.ndarray) -> int:
    """Lit points times lights: the sum of a picture in which each of them sends back exactly 1.

    (N.H)**0 = 1 where N.L > 0, every ray carries all of its light, and all else is dark.
    """
    black, white = [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]
    plain = {name: Material(k_h=1.0, k_s=1.0, k_t=1.0, phong_exponent=0.0, refractive_index=m.refractive_index)
             for name, m in scene.materials.items()}
    bright = [PointLight(p.position, white) if isinstance(p, PointLight) else DirectionalLight(p.direction, white)
              for p in scene.lights]
    counting = Scene(objects=scene.objects, materials=plain, lights=bright, background=ConstantBackground(black),
                     ambient=black, precision=scene.precision)
    trees = eqx.tree_at(lambda t: t.nodes.object, trees, jnp.where(counted, trees.nodes.object, -1))
    effects = replace(plan.effects, ambient=False, diffuse=False, highlight=True, textures=False)
    film = replay_passes(counting, camera, trees, replace(plan, effects=effects, highlight_models=("halfway",) * len(plain)))
    return round(float(np.asarray(film[..., 0], np.float64).sum()))
