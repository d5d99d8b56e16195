"""What a scene calls for, decided once, outside `jit`: effects, depth, and room for the rays."""

from collections.abc import Collection
from dataclasses import dataclass, fields, replace
from math import ceil

import numpy as np

from .._errors import CapacityError, SceneError
from ..numerics._stage import LANES
from ..numerics._workers import processors
from ..scene import (
    Camera,
    Plane,
    Scene,
    Sphere,
    check_footprint,
    is_traced,
    material_names,
    numbered_objects,
    texture_names,
)
from ._effects import Effects, as_effects, calls_for, decide_effects

BLOCK = 2**13
FOOTPRINT_BLOCK = 2**12
"""Rays with a footprint have more to carry: a smaller block stays in the cache."""
MOST_PIXELS_A_PASS = 160 * 1024
FEWEST_PIXELS_A_PASS = 2**14
"""A picture smaller than two of these is one pass; a larger one has a pass for each processor, or more."""
PAGE = 1024
"""Arrays of so many numbers, or a multiple, begin at the same places of the cache and drive each other out (measured: up to twice the time)."""
PIXELS_UNDER_JIT = 80 * 1024
"""Of a pass whose rays nobody has counted: its room is cleared in memory that is fetched anew, which takes time."""
LARGEST_TREE = 2**18
"""Of one camera ray under `jit` without a plan; beyond it the picture is NaN."""
WORST_CASE_LIMIT = 2**24
LARGEST_ROOM = 2**25
"""Rays other than camera rays in a pass, about 3 GiB; beyond it a picture ends with an error, not with the memory."""
LIKELY_DESCENDANTS = 2.0
"""Rays other than camera rays that a pixel is first given room for; more room costs memory and a little time,
less means that the program of a scene with much glass is compiled twice."""


@dataclass(frozen=True)
class Plan:
    """Static and hashable: it selects the compiled program.

    A picture is traced in `passes`. A pass has `pass_pixels` camera rays, followed in blocks of `block` rays as
    their descendants are; `capacity` is the room for descendants in one pass. The sizes are such that a pass
    stays in the cache and a block below the length from which XLA splits its loops between threads, which
    was measured to be slower.
    """

    effects: Effects
    max_depth: int
    footprint: int
    """Rays have the footprint of one of footprint x footprint squares of a pixel; 0: none."""
    total_reflection_is_full: bool
    mirrors: tuple[bool, ...]
    """Which objects spawn mirror rays, by object number."""
    transparent: tuple[bool, ...]
    """Which objects let light through, by object number."""
    material_of: tuple[int, ...]
    """The material of each object, by number."""
    solids: tuple[int, ...]
    """The transparent solids, smallest first: where they overlap, the first one counts."""
    highlight_models: tuple[str, ...]
    """By material: "halfway", "reflected" or "off"."""
    k_a_textures: tuple[int, ...]
    """By material: the number of its texture, -1 without one."""
    k_d_textures: tuple[int, ...]
    picture: tuple[int, int]
    """Width and height in pixels."""
    passes: int
    pass_pixels: int
    """A whole number of blocks."""
    block: int
    capacity: int

    @property
    def branching(self) -> bool:
        """Does any ray have children?"""
        return self.effects.branching or self.effects.footprint

    @property
    def blocks(self) -> int:
        """The most blocks that the rays of a pass can take: among the descendants one a depth may be partly filled."""
        return self.pass_pixels // self.block + (
            ceil(self.capacity / self.block) + 3 * self.max_depth if self.capacity else 0
        )

    @property
    def slots(self) -> int:
        """Length of the arrays that hold all rays of a pass, with one block to spare at the end."""
        return self.pass_pixels + self.capacity + (self.block if self.capacity else 0)

    def shortfall(self, needed: "Plan") -> str | None:
        """What this plan leaves out of `needed`, a plan made for the scene at hand; None if nothing."""
        if self.picture != needed.picture:
            return f"it was made for {self.picture[0]}x{self.picture[1]} pixels, not {needed.picture[0]}x{needed.picture[1]}"
        same = ("material_of", "highlight_models", "k_a_textures", "k_d_textures", "total_reflection_is_full")
        if any(getattr(self, field) != getattr(needed, field) for field in same):
            return "it was made for a scene with other objects, materials or textures"
        if self.footprint != needed.footprint:
            return f"it was made with footprint = {self.footprint}, not {needed.footprint}"
        if self.solids != needed.solids:
            return "it was made for a scene whose transparent solids lie in another order of size"
        missing = [
            f.name for f in fields(Effects) if getattr(needed.effects, f.name) and not getattr(self.effects, f.name)
        ]
        if missing:
            return f"it leaves out {', '.join(missing)}, which the scene calls for"
        for have, want, what in ((self.mirrors, needed.mirrors, "k_s"), (self.transparent, needed.transparent, "k_t")):
            if any(w and not h for h, w in zip(have, want, strict=True)):
                return f"some object had {what} = 0 when it was made, and has not now"
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
    camera: Camera,
    *,
    free: Collection[str] = (),
    max_depth: int | None = None,
    capacity: int | None = None,
    footprint: int | None = None,
    pass_of: int = MOST_PIXELS_A_PASS,
    block_of: int | None = None,
) -> Plan:
    """Plan the rendering of a scene by a camera, in passes of at most `pass_of` pixels and blocks of at most `block_of` rays.

    `free` names coefficients ("glass.k_s") whose derivative is wanted although they may be zero now: they
    keep their effect. `capacity` is the room for rays other than camera rays in one pass; without it
    the room is the worst case, every ray branching down to `max_depth` (at most 16 M rays).
    """
    depth = scene.max_depth if max_depth is None else max_depth
    objects, names, textures = numbered_objects(scene), material_names(scene), texture_names(scene)
    effects = as_effects(decide_effects(scene, free, depth, footprint))
    mirrors = tuple(calls_for(scene, o.material, "k_s", free) is not None for o in objects)
    transparent = tuple(calls_for(scene, o.material, "k_t", free) is not None for o in objects)
    materials = [scene.materials[name] for name in names]
    trees = scene.footprint if footprint is None else footprint
    check_footprint(trees, "")
    passes, pass_pixels, block = _split(
        camera.width * camera.height, pass_of, block_of or (FOOTPRINT_BLOCK if trees else BLOCK)
    )
    plan = Plan(
        effects=effects,
        max_depth=depth,
        total_reflection_is_full=scene.total_internal_reflection == "full",
        mirrors=mirrors,
        transparent=transparent,
        material_of=tuple(names.index(o.material) for o in objects),
        solids=_smallest_first(objects, transparent),
        highlight_models=tuple(m.highlight for m in materials),
        k_a_textures=tuple(-1 if m.k_a_texture is None else textures.index(m.k_a_texture) for m in materials),
        k_d_textures=tuple(-1 if m.k_d_texture is None else textures.index(m.k_d_texture) for m in materials),
        picture=(camera.width, camera.height),
        passes=passes,
        pass_pixels=pass_pixels,
        block=block,
        capacity=0,
        footprint=trees,
    )
    worst = _worst_case(plan)
    return plan.with_capacity(worst if capacity is None else min(capacity, worst))


def unmeasured_plan(scene: Scene, camera: Camera, *, max_depth: int | None, footprint: int | None) -> Plan:
    """A plan for traced values, whose rays nobody can count: with room for the tree of a pass that is likely.

    The tree of any one camera ray has room, up to `LARGEST_TREE`: a pass that needs more is traced in parts.
    """
    room = likely_room(camera, PIXELS_UNDER_JIT)
    plan = make_plan(scene, camera, max_depth=max_depth, capacity=room, footprint=footprint, pass_of=PIXELS_UNDER_JIT)
    return plan.with_capacity(max(plan.capacity, min(_largest_tree(plan), LARGEST_TREE)))


def likely_room(camera: Camera, pass_of: int = MOST_PIXELS_A_PASS) -> int:
    """Room for descendants in one pass that most scenes do not exceed: a capacity to try first."""
    return int(LIKELY_DESCENDANTS * _split(camera.width * camera.height, pass_of, BLOCK)[1])


def _split(pixels: int, pass_of: int, most: int) -> tuple[int, int, int]:
    """Passes of at most `pass_of` pixels, camera rays a pass, and rays a block of at most `most`, with little left over."""
    passes = max(ceil(pixels / pass_of), min(processors(), pixels // FEWEST_PIXELS_A_PASS), 1)
    if passes > 1:
        passes = ceil(passes / processors()) * processors()
    in_pass = ceil(pixels / passes)
    blocks = ceil(in_pass / most)
    block = ceil(in_pass / blocks / LANES) * LANES
    if blocks * block % PAGE == 0:
        block += LANES
    return passes, blocks * block, block


def _worst_case(plan: Plan) -> int:
    return min(plan.pass_pixels * _largest_tree(plan), WORST_CASE_LIMIT)


def _largest_tree(plan: Plan) -> int:
    """The most rays that one camera ray can bring about, itself not counted."""
    branches = any(plan.mirrors) + any(plan.transparent)
    rays = sum(branches**level for level in range(1, plan.max_depth)) if plan.effects.branching else 0
    return 3 * (rays + 1) if plan.footprint else rays


def _smallest_first(objects, transparent: tuple[bool, ...]) -> tuple[int, ...]:
    def size(index):
        thing = objects[index]
        if isinstance(thing, Plane):
            return np.inf
        return float(thing.radius) if not is_traced(thing.radius) else 0.0

    solids = [i for i, thing in enumerate(objects) if transparent[i] and isinstance(thing, (Sphere, Plane))]
    unknown = [objects[i].name for i in solids if isinstance(objects[i], Sphere) and is_traced(objects[i].radius)]
    if unknown and len(solids) > 1:
        raise SceneError(
            f"object {unknown[0]!r}: its radius is traced, so which transparent solid lies inside which is not known; "
            "pass plan=diffwhitted.plan(scene, camera), made outside jit, grad or vmap"
        )
    return tuple(sorted(solids, key=lambda i: (size(i), -i)))
