"""What a picture is made of: which effects are at work and why, what each costs, and which rays there are."""

from collections.abc import Callable, Collection
from dataclasses import asdict, dataclass
from typing import Any

from ..scene import AbstractCamera, Scene, depth_number, find_parameter, near
from ..tree import decide_effects, make_plan
from ._effects import EffectCost, PictureCost, picture_cost
from ._rays import RayCounts, count_rays
from ._search import SearchCounts


@dataclass(frozen=True)
class ExplainedEffect:
    """One effect: is it on, why, and what it costs; None where it is off or nothing was measured."""

    name: str
    on: bool
    why: str
    cost: EffectCost | None = None


@dataclass(frozen=True)
class Explanation:
    """What `explain` found out about a scene seen by a camera."""

    width: int
    height: int
    max_depth: int
    effects: tuple[ExplainedEffect, ...]
    rays: RayCounts
    search: dict[str, SearchCounts]
    """Boxes and surfaces tested a ray, by the kinds of `rays.by_kind` and "shadow", where surfaces are searched by a
    tree; empty where every ray asks every surface.
    """
    cost: PictureCost | None
    """None where nothing was measured."""

    def to_json(self) -> dict[str, Any]:
        """Everything as JSON values."""
        content = asdict(self)
        content["rays"] = {"total": self.rays.total, **content["rays"], "by_level": list(self.rays.by_level)}
        if self.cost is not None:
            del content["cost"]["effects"]  # they stand with the effects
        return content | {"effects": list(content["effects"])}


def explain(
    scene: Scene,
    camera: AbstractCamera,
    *,
    free: Collection[str] = (),
    max_depth: int | None = None,
    measure: bool = True,
    on_measure: Callable[[str], None] | None = None,
) -> Explanation:
    """Every effect with its reason and its cost, the rays by level and kind, and the parts of the work.

    - `free`: names of coefficients ("glass.k_s") that a fit leaves free: they keep their effect at 0.
    - `max_depth`: in place of the scene's.
    - `measure`: time the picture without each effect in turn. Each takes a program of its own to compile
      (seconds), so False gives reasons and rays much sooner.
    - `on_measure`: called with words for each program before it is compiled.

    Raises `SceneError` for a free name that the scene does not have, and for a max_depth that is not one.
    """
    for name in free:
        find_parameter(scene, name)
    max_depth = depth_number(max_depth)
    scene, camera = near(scene, camera)
    rays, search, room = count_rays(scene, camera, free, max_depth)
    plan = make_plan(scene, camera, free=free, max_depth=max_depth, capacity=room)
    decisions = decide_effects(scene, free, max_depth)
    cost = (
        picture_cost(scene, camera, plan, [d.name for d in decisions if d.on], on_measure or (lambda words: None))
        if measure
        else None
    )
    costs = cost.effects if cost else {}
    effects = tuple(ExplainedEffect(d.name, d.on, d.why, costs.get(d.name)) for d in decisions)
    return Explanation(camera.width, camera.height, plan.max_depth, effects, rays, search, cost)
