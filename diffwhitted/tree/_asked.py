"""What is asked of a scene when its effects are decided: which coefficients are at work, and why."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .._errors import SceneError
from ..scene import SWITCHED, AbstractCamera, Material, Scene, Sheet, is_traced, shared_sheets
from ..shapes import AbstractObject


@dataclass(frozen=True)
class Asked:
    """A scene, and what is asked of its picture."""

    scene: Scene
    free: frozenset[str]
    """Coefficients that a fit leaves free, by name."""
    depth: int
    trees: int
    """The footprint."""
    cameras: tuple[AbstractCamera, ...]
    """That may look at it."""

    @cached_property
    def made_of(self) -> Mapping[str, AbstractObject]:
        """The materials in use by name, each with its first object, in the order of the objects."""
        first: dict[str, AbstractObject] = {}
        for thing in self.scene.objects:
            first.setdefault(thing.material, thing)
        return first

    def first_made_of(self, why: Callable[[str], str | None]) -> str | None:
        """The first object for whose material (by name) there is a reason, with the reason, or None."""
        found = ((thing.name, why(material)) for material, thing in self.made_of.items())
        return next((f"object {name!r}: {reason}" for name, reason in found if reason), None)

    def first_with(self, coefficient: str) -> str | None:
        """The first object for which a coefficient is at work, with the reason, or None."""
        return self.first_made_of(lambda material: self.reasons.get((material, coefficient)))

    def users(self, coefficient: str) -> list[AbstractObject]:
        """The objects for which a coefficient is at work."""
        return [thing for thing in self.scene.objects if self.reasons.get((thing.material, coefficient))]

    def check_clear(self) -> None:
        """Raise `SceneError` for an object that lets light through and is of a kind that cannot; what is traced may
        be 0.
        """
        for thing in () if all(thing.CLEAR for thing in self.scene.objects) else self.users("k_t"):
            if not (thing.CLEAR or is_traced(self.scene.materials[thing.material].values["k_t"])):
                reason = self.reasons[thing.material, "k_t"]
                raise SceneError(
                    f"object {thing.name!r}: {reason}, and a {thing.TYPE} lets no light through; allowed is k_t = 0. "
                    "For glass, use a closed mesh"
                )

    @cached_property
    def reasons(self) -> Mapping[tuple[str, str], str]:
        """Why a coefficient of a material is at work, where it is."""
        found = (
            ((name, coefficient), _reason(material, name, coefficient, source, self.free))
            for name, material in self.scene.materials.items()
            for coefficient, source in material.sources.items()
        )
        return {at: reason for at, reason in found if reason}

    @cached_property
    def sheets(self) -> tuple[Sheet, ...]:
        """The surfaces in which transparent objects touch others."""
        return shared_sheets(self.scene.placed_objects(), {thing.name for thing in self.users("k_t")})


def frees_ambient(free: Collection[str]) -> bool:
    """Is ambient light, or a part of it, among the names of what a fit leaves free?"""
    return any(name == "scene.ambient" or name.startswith("scene.ambient.") for name in free)


def calls_for(scene: Scene, material: str, coefficient: str, free: Collection[str] = ()) -> str | None:
    """Why a coefficient of a material is at work ("glass.k_t = 0.7", "... is free"), or None if it is zero."""
    record = scene.materials[material]
    return _reason(record, material, coefficient, record.sources[coefficient], free)


def _reason(record: Material, material: str, coefficient: str, source: str, free: Collection[str]) -> str | None:
    """`calls_for`, for a coefficient whose value is that of another one, its source."""
    if coefficient == "k_h" and record.highlight == "off":
        return None
    if coefficient in SWITCHED and coefficient not in record.switched:
        return None
    name = f"{material}.{coefficient}"
    if source != coefficient and f"{material}.{source}" in free:
        return f"{material}.{source} is free and gives {coefficient}"
    value = record.values[source]
    if name in free:
        return f"{name} is free in the fit"
    if is_traced(value):
        return f"{name} is traced and may be anything"
    value = np.asarray(value)
    if not np.any(value > 0):
        return None
    return f"{name} = {np.array2string(value, precision=4, separator=', ', legacy=False)}"
