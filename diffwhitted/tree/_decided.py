"""The effects of one picture, decided one by one, each with its reason."""

from collections.abc import Collection
from dataclasses import dataclass

from ..scene import AbstractCamera, Scene
from ._asked import Asked
from ._effects import Effects, effect_rows


@dataclass(frozen=True)
class Decision:
    """One effect, on or off, and the reason in words."""

    name: str
    on: bool
    why: str


def decide_effects(
    scene: Scene,
    free: Collection[str] = (),
    max_depth: int | None = None,
    footprint: int | None = None,
    camera: AbstractCamera | None = None,
) -> tuple[Decision, ...]:
    """Decide every effect for a scene and the free coefficients of a fit, in the order of the table.

    `max_depth` and `footprint` replace the scene's, `camera` its cameras.
    """
    depth = scene.max_depth if max_depth is None else max_depth
    cameras = tuple(scene.cameras.values()) if camera is None else (camera,)
    asked = Asked(scene, frozenset(free), depth, scene.footprint if footprint is None else footprint, cameras)
    asked.check_clear()
    decided: list[Decision] = []
    on: set[str] = set()
    for row in effect_rows():
        needed, missing = row.needs
        why_not = row.forbidden(asked) or (missing if needed and not on.intersection(needed) else None)
        reason = None if why_not else row.called_for(asked)
        decided.append(Decision(row.name, reason is not None, reason or why_not or row.otherwise))
        if reason is not None:
            on.add(row.name)
    return tuple(decided)


def as_effects(decisions: tuple[Decision, ...]) -> Effects:
    return Effects(frozenset(decision.name for decision in decisions if decision.on))
