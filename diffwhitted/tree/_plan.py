"""What a scene calls for, decided once, outside `jit`: effects, depth, and room for the rays."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from .._errors import CapacityError
from ..numerics._stage import LANES
from ..numerics._workers import processors
from ..scene import (
    BLUR_SAMPLES,
    HIGHLIGHTS,
    AbstractCamera,
    Scene,
    Sheet,
    Tables,
    is_traced,
    marks_of,
    material_names,
    tabulate,
    textured_rows,
)  # fmt: skip
from ._asked import Asked, calls_for
from ._effects import Effects, as_effects, decide_effects, effect_rows
from ._points import trees_or_points

BLOCK = 2**13
FOOTPRINT_BLOCK = 2**12
"""Rays with a footprint have more to carry: a smaller block stays in the cache."""
MOST_PIXELS_A_PASS = 160 * 1024
FEWEST_PIXELS_A_PASS = 2**14
"""A picture smaller than two of these is one pass; a larger one has a pass for each processor, or more."""
PAGE = 1024
"""Arrays of so many numbers, or a multiple, begin at the same places of the cache and drive each other out (measured:
up to twice the time).
"""
PIXELS_UNDER_JIT = 80 * 1024
"""Of a pass whose rays nobody has counted: its room is cleared in memory that is fetched anew, which takes time."""
LARGEST_TREE = 2**18
"""Of one camera ray under `jit` without a plan; beyond it the picture is NaN."""
MOST_PASSED = 2
"""So many silhouettes a ray may run past before those that follow count whole or not at all."""
WORST_CASE_LIMIT = 2**24
LARGEST_ROOM = 2**25
"""Rays other than camera rays in a pass, about 3 GiB; beyond it a picture ends with an error, not with the memory."""
LIKELY_DESCENDANTS = 2.0
"""Rays other than camera rays that a pixel is first given room for; more room costs memory and a little time,
less means that the program of a scene with much glass is compiled twice."""


@dataclass(frozen=True)
class Plan:
    """Static and hashable: it selects the compiled program, and says nothing of single objects, materials or lights.

    A picture is traced in `passes`. A pass has `pass_pixels` camera rays, followed in blocks of `block` rays as
    their descendants are; `capacity` is the room for descendants in one pass. The sizes are such that a pass
    stays in the cache and a block below the length from which XLA splits its loops between threads, which
    was measured to be slower.
    """

    effects: Effects
    max_depth: int
    footprint: int
    """Rays have the footprint of one of footprint x footprint squares of a pixel; 0: none."""
    samples: int
    """Points along the side of a pixel in place of a footprint that something in the scene does not know; else 1."""
    bands: int
    """Of the spectrum, each a tree; 1 where nothing disperses light."""
    chances: int
    """Trees at the least, over which what is left to chance (roughness, a lens) is averaged; 1 where nothing is."""
    total_reflection_is_full: bool
    highlight_models: tuple[str, ...]
    """That there are in the scene: "halfway", "reflected", "off"."""
    textured: tuple[tuple[str, ...], ...]
    """The coefficients that have a texture somewhere, those that always wear the same one together."""
    weighed_by: tuple[str, ...]
    """The coefficients that effects add to the weights of branches."""
    zero_weights: bool
    """A branch that weighs nothing may be followed, for the derivative in its weight."""
    at_work: tuple[str, ...]
    """k_s and k_t, by the names of their materials, that were not zero or free when it was made: their branches are
    followed whatever they are now. Not read by programs: see `program`.
    """
    shared: tuple[Sheet, ...]
    """The surfaces in which transparent objects touched others when it was made, by the names of the objects. Not read
    by programs either.
    """
    picture: tuple[int, int]
    """Width and height in pixels."""
    passes: int
    pass_pixels: int
    """A whole number of blocks."""
    block: int
    capacity: int

    @property
    def program(self) -> "Plan":
        """What selects a compiled program: the plan without names."""
        return replace(self, at_work=(), shared=())

    @property
    def draws(self) -> int:
        """Trees that a place in a pixel takes at the least."""
        return self.bands * self.chances

    @property
    def side(self) -> int:
        """Trees or points along the side of a pixel."""
        return self.footprint or self.samples

    @property
    def branching(self) -> bool:
        """Does any ray have children?"""
        return self.effects.branching or bool(self.footprint)

    @property
    def blocks(self) -> int:
        """The most blocks that the rays of a pass can take: one may be partly filled for each depth and silhouette."""
        return self.pass_pixels // self.block + (
            ceil(self.capacity / self.block) + (1 + MOST_PASSED) * self.max_depth if self.capacity else 0
        )

    @property
    def slots(self) -> int:
        """Length of the arrays that hold all rays of a pass, with one block to spare at the end."""
        return self.pass_pixels + self.capacity + (self.block if self.capacity else 0)

    def shortfall(self, needed: "Plan") -> str | None:
        """What this plan leaves out of `needed`, a plan made for the scene at hand; None if nothing."""
        if self.picture != needed.picture:
            return (
                f"it was made for {self.picture[0]}x{self.picture[1]} pixels, not "
                f"{needed.picture[0]}x{needed.picture[1]}"
            )
        if self.footprint != needed.footprint:
            return f"it was made with footprint = {self.footprint}, not {needed.footprint}"
        missing = sorted(needed.effects.on - self.effects.on, key=[row.name for row in effect_rows()].index)
        if missing:
            return f"it leaves out {', '.join(missing)}, which the scene calls for"
        idle = [name for name in needed.at_work if name not in self.at_work]
        if needed.zero_weights and not self.zero_weights and idle:
            return f"{idle[0]} was zero when it was made, and may not be now"
        if touching := [sheet for sheet in needed.shared if sheet not in self.shared]:
            return f"objects {touching[0][0][0]!r} and {touching[0][1][0]!r} did not share a surface when it was made"
        textured = not needed.textured or self.textured == needed.textured
        if not (textured and set(needed.highlight_models) <= set(self.highlight_models)):
            return "it was made for a scene with other highlights or textures"
        if self.bands < needed.bands or self.chances < needed.chances:
            return "it was made for fewer bands, or for fewer samples of what is left to chance"
        if self.total_reflection_is_full != needed.total_reflection_is_full:
            return "it was made for another total_internal_reflection"
        return None

    def with_capacity(self, rays: int) -> "Plan":
        """The same plan with room for `rays` rays (other than camera rays) a pass, in whole blocks."""
        if not self.branching:
            return self
        if rays > LARGEST_ROOM:
            raise CapacityError(
                f"the ray tree needs room for {rays:,} rays a pass of {self.pass_pixels:,} pixels, more than "
                f"{LARGEST_ROOM:,}; lower max_depth, or set fewer of k_s and k_t above zero"
            )
        return replace(self, capacity=max(1, ceil(rays / self.block)) * self.block)


def make_plan(
    scene: Scene,
    camera: AbstractCamera,
    *,
    free: Collection[str] = (),
    max_depth: int | None = None,
    capacity: int | None = None,
    footprint: int | None = None,
    pass_of: int = MOST_PIXELS_A_PASS,
    block_of: int | None = None,
) -> Plan:
    """Plan the rendering of a scene by a camera, in passes of at most `pass_of` pixels and blocks of at most
    `block_of` rays.

    `free` names coefficients ("glass.k_s") whose derivative is wanted although they may be zero now: they
    keep their effect. `capacity` is the room for rays other than camera rays in one pass; without it
    the room is the worst case, every ray branching down to `max_depth` (at most 16 M rays).
    """
    depth = scene.max_depth if max_depth is None else max_depth
    trees, points = trees_or_points(scene, scene.footprint if footprint is None else footprint)
    effects = as_effects(decide_effects(scene, free, depth, trees, camera))
    passes, pass_pixels, block = _split(
        camera.width * camera.height, pass_of, block_of or (FOOTPRINT_BLOCK if trees else BLOCK)
    )
    used = {thing.material: scene.materials[thing.material] for thing in scene.objects}
    plan = Plan(
        effects=effects,
        max_depth=depth,
        footprint=trees,
        samples=points,
        bands=scene.bands if "dispersion" in effects else 1,
        chances=_chances(scene, camera, effects),
        total_reflection_is_full=scene.total_internal_reflection == "full",
        highlight_models=tuple(model for model in HIGHLIGHTS if any(m.highlight == model for m in used.values())),
        textured=texture_groups(scene) if "textures" in effects else (),
        weighed_by=tuple(
            name for row in effect_rows() if row.weighs and row.name in effects for name in row.coefficients
        ),
        zero_weights=effects.branching and _may_weigh_nothing(scene, used, free),
        at_work=tuple(
            f"{name}.{coefficient}"
            for name in sorted(used)
            for coefficient in ("k_s", "k_t")
            if calls_for(scene, name, coefficient, free)
        ),
        shared=Asked(scene, frozenset(free), depth, trees, (camera,)).sheets if "shared_surfaces" in effects else (),
        picture=(camera.width, camera.height),
        passes=passes,
        pass_pixels=pass_pixels,
        block=block,
        capacity=0,
    )
    worst = _worst_case(plan)
    return plan.with_capacity(worst if capacity is None else min(capacity, worst))


def tables_of(scene: Scene, plan: Plan) -> Tables:
    """The scene as tables, with the marks that the plan asks for; outside a program, as names are read here."""
    shared = plan.shared if plan.effects.shared_surfaces else ()
    marks = marks_of(scene, plan.at_work, where_traced=plan.zero_weights, shared=shared, searched=False,
                     outlines=plan.footprint > 0)  # fmt: skip
    return tabulate(scene, marks)


def unmeasured_plan(scene: Scene, camera: AbstractCamera, *, max_depth: int | None, footprint: int | None) -> Plan:
    """A plan for traced values, whose rays nobody can count: with room for the tree of a pass that is likely.

    The tree of one camera ray (see `_largest_tree`) has room, up to `LARGEST_TREE`: larger passes are traced in parts.
    """
    room = likely_room(camera, PIXELS_UNDER_JIT)
    plan = make_plan(scene, camera, max_depth=max_depth, capacity=room, footprint=footprint, pass_of=PIXELS_UNDER_JIT)
    return plan.with_capacity(max(plan.capacity, min(_largest_tree(plan), LARGEST_TREE)))


def likely_room(camera: AbstractCamera, pass_of: int = MOST_PIXELS_A_PASS) -> int:
    """Room for descendants in one pass that most scenes do not exceed: a capacity to try first."""
    return int(LIKELY_DESCENDANTS * _split(camera.width * camera.height, pass_of, BLOCK)[1])


def _split(pixels: int, pass_of: int, most: int) -> tuple[int, int, int]:
    """Passes of at most `pass_of` pixels, camera rays a pass, and rays a block of at most `most`, with little left
    over.
    """
    passes = max(ceil(pixels / pass_of), min(processors(), pixels // FEWEST_PIXELS_A_PASS), 1)
    if passes > 1:
        passes = ceil(passes / processors()) * processors()
    in_pass = ceil(pixels / passes)
    blocks = ceil(in_pass / most)
    block = ceil(in_pass / blocks / LANES) * LANES
    if blocks * block % PAGE == 0:
        block += LANES
    return passes, blocks * block, block


def texture_groups(scene: Scene) -> tuple[tuple[str, ...], ...]:
    """The textured coefficients, those that wear the same texture on every material together."""
    groups: dict[tuple, list[str]] = {}
    for row in textured_rows():
        worn = tuple(scene.materials[name].texture_at_work(row.name) for name in material_names(scene))
        if any(worn):
            groups.setdefault(worn, []).append(row.name)
    return tuple(map(tuple, groups.values()))


def _chances(scene: Scene, camera: AbstractCamera, effects: Effects) -> int:
    """The most samples that a rough material, or a camera that blurs, asks for."""
    used = {thing.material for thing in scene.objects} if "gloss" in effects else ()
    blurred = [camera.blur_samples or BLUR_SAMPLES] if effects.lens or effects.motion else []
    return max([1, *blurred, *(scene.materials[name].roughness_samples for name in used)])


def _may_weigh_nothing(scene: Scene, used: Collection[str], free: Collection[str]) -> bool:
    """Is the derivative in some k_s or k_t wanted that may be zero?"""

    def may(material: str, coefficient: str) -> bool:
        value = scene.materials[material].values[coefficient]
        if is_traced(value):
            return True
        return f"{material}.{coefficient}" in free and not np.any(np.asarray(value) > 0)

    return any(may(material, coefficient) for material in used for coefficient in ("k_s", "k_t"))


def _worst_case(plan: Plan) -> int:
    return min(plan.pass_pixels * _largest_tree(plan), WORST_CASE_LIMIT)


def _largest_tree(plan: Plan) -> int:
    """The most rays that one camera ray can bring about, but for what those past a silhouette send on in their turn."""
    branches = plan.effects.reflection + plan.effects.refraction
    rays = sum(branches**level for level in range(1, plan.max_depth)) if plan.effects.branching else 0
    return (1 + MOST_PASSED) * (rays + 1) if plan.footprint else rays
