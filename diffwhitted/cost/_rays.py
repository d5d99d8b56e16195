"""Which rays a picture takes: by level, by kind, and pixel by pixel."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..illumination import lit
from ..numerics._vector import Vec3
from ..records import member, member_count
from ..rendering._antialias import antialias
from ..rendering._passes import recorded_with_room
from ..scene import AbstractCamera, Scene, Tables, depth_number, near
from ..tree import (
    BRANCH_NAMES,
    Plan,
    Record,
    decide_effects,
    grid,
    likely_room,
    make_plan,
    pixel_of,
    replay,
    tables_of,
)  # fmt: skip
from ._search import SearchCounts, count_tests


@dataclass(frozen=True)
class RayCounts:
    """How many rays one sample a pixel takes; `sum(by_level) == sum(by_kind.values()) == total`."""

    by_level: tuple[int, ...]
    """The first entry counts the camera rays, the last the deepest rays that there are."""
    by_kind: dict[str, int]
    """"camera", "mirror" (weighted by k_s), "transmitted" (k_t), "total" (total internal reflection), "past"
    (what an object's silhouette leaves of a pixel, where rays have a footprint)."""
    background: int
    """Of these, the rays that met nothing."""
    shadow: int
    """Beside these, the rays from lit points (N.L > 0) to lights; 0 where nothing casts shadows."""
    cut_off: dict[str, int]
    """The rays past `max_depth`, by kind: they return black and are not among those above."""

    @property
    def total(self) -> int:
        return sum(self.by_level)


@dataclass(frozen=True, eq=False)
class RayMaps:
    """What each pixel takes, arrays (height, width) of whole numbers."""

    rays: np.ndarray
    """Of one sample, the camera ray among them."""
    depth: np.ndarray
    """The level of the deepest of them, 1 for the camera ray."""
    squares: np.ndarray
    """Into how many squares adaptive antialiasing divides the pixel, 1 to 64; their corners are its samples."""
    threshold: float
    """Of that antialiasing."""


def ray_maps(scene: Scene, camera: AbstractCamera, *, max_depth: int | None = None, threshold: float = 0.1) -> RayMaps:
    """Where a picture spends its rays.

    `threshold` is that of `antialias`. Raises `SceneError` for a max_depth or a threshold that is none.
    """
    scene, camera = near(scene, camera)
    plan, trees = _recorded(scene, camera, (), max_depth)
    squares = antialias(scene, camera, threshold, max_depth=max_depth).squares
    shape, there = (camera.height, camera.width), are_rays(camera, plan, trees)
    sample, level = (np.asarray(a)[there] for a in (trees.nodes.origin.sample, trees.nodes.origin.level))
    pixel, count = pixel_of(plan, np.nonzero(there)[0], sample), shape[0] * shape[1]
    rays, depth = np.bincount(pixel, minlength=count), np.zeros(count, int)
    np.maximum.at(depth, pixel, level)
    return RayMaps(rays.reshape(shape), depth.reshape(shape), squares, threshold)


def count_rays(
    scene: Scene, camera: AbstractCamera, free: Collection[str], max_depth: int | None
) -> tuple[RayCounts, dict[str, SearchCounts], int]:
    """The rays, what the search tests for them, and the room that a plan needs for them."""
    depth = scene.max_depth if max_depth is None else max_depth
    shadows = any(d.name == "shadows" and d.on for d in decide_effects(scene, free, depth))
    # One level more than asked for shows what the depth cuts off.
    plan, trees = _recorded(scene, camera, free, depth + 1)
    level = np.where(are_rays(camera, plan, trees), np.asarray(trees.nodes.origin.level), 0)
    kind = np.asarray(trees.nodes.origin.branch)
    kept = (level > 0) & (level <= depth)
    counts = RayCounts(
        by_level=tuple(map(int, np.bincount(level[kept], minlength=2)[1:])),
        by_kind=_by_kind(kind[kept]),
        background=int((np.asarray(trees.nodes.primitive)[kept] < 0).sum()),
        shadow=_shadow_rays(scene, camera, plan, trees, kept) if shadows else 0,
        cut_off={name: count for name, count in _by_kind(kind[level > depth]).items() if name != "camera"},
    )
    tests = count_tests(tables_of(scene, plan), camera, plan.program, trees, kept, scene.shadows if shadows else None)
    return counts, tests, int((kept & (level > 1)).sum(axis=1).max())


def _recorded(
    scene: Scene, camera: AbstractCamera, free: Collection[str], max_depth: int | None
) -> tuple[Plan, Record]:
    """The trees of the picture, without what lights see."""
    plan = make_plan(scene, camera, free=free, max_depth=depth_number(max_depth), capacity=likely_room(camera))
    plan = replace(plan, effects=plan.effects.switched(shadows=False, tinted_shadows=False))
    return recorded_with_room(scene, camera, plan)


def are_rays(camera: AbstractCamera, plan: Plan, trees: Record) -> np.ndarray:
    """Which slots (passes, slots) of recorded trees hold a ray: not those past the picture or past the tree's end."""
    slot = np.arange(plan.slots)
    inside = pixel_of(plan, np.arange(plan.passes)[:, None], slot) < camera.width * camera.height
    end = plan.pass_pixels + np.asarray(trees.descendants)[:, None]
    return (inside & (slot < plan.pass_pixels)) | ((slot >= plan.pass_pixels) & (slot < end))


def _by_kind(kind: np.ndarray) -> dict[str, int]:
    return dict(zip(BRANCH_NAMES, map(int, np.bincount(kind, minlength=len(BRANCH_NAMES))), strict=True))


def _shadow_rays(scene: Scene, camera: AbstractCamera, plan: Plan, trees: Record, counted: np.ndarray) -> int:
    """Lit points times lights: the sum of a picture to which each of them sends exactly 1, and every ray carries all
    of it.
    """
    tables = tables_of(scene, plan)
    whole = jax.tree.map(jnp.ones_like, tables.coefficients["k_s"])
    tables = replace(tables, coefficients=tables.coefficients | {"k_s": whole, "k_t": whole})
    trees = eqx.tree_at(lambda t: t.nodes.primitive, trees, jnp.where(counted, trees.nodes.primitive, -1))
    plan = replace(plan, effects=plan.effects.switched(distance_fade=False))
    return round(float(np.asarray(_lit_points(tables, camera, trees, plan.program), np.float64).sum()))


@eqx.filter_jit
def _lit_points(tables: Tables, camera: AbstractCamera, trees: Record, plan: Plan):
    def lamps(tables: Tables, plan: Plan, nodes, at, needed) -> Vec3:
        """The number of lights that are before the surface."""
        there, total = (nodes.primitive >= 0).astype(at.point.dtype), jnp.zeros_like(at.point.x)
        for lights in tables.lights:
            for k in range(member_count(lights)):
                total = total + lit(at.shading_normal, member(lights, k).arriving(at.point)[0])
        return Vec3(total * there, total * there, total * there)

    def one_pass(inputs):
        number, tree = inputs
        middle = jnp.full(2, 0.5, camera.look_from.dtype)
        return replay(tables, camera, tree, plan, grid(plan, camera, number, middle), lamps).x

    return jax.lax.map(one_pass, (jnp.arange(plan.passes, dtype=jnp.int32), trees))
