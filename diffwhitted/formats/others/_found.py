"""What a reader of another program's file has found, until it is a scene."""

import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..._errors import SceneError, SceneNote
from ...scene import AbstractObject, Checker, Material, Scene
from .._losses import Losses
from ._boards import Board, simplified
from ._placed import Maker

MOST_OBJECTS = 100_000
"""Each is a record of its own."""
MOST_LIGHTS = 1000
"""Each is asked from each point."""


@dataclass(frozen=True, eq=False)
class Paint:
    """A material as a file has it: coefficients by name, a number or (3,) each; the boards of those that vary, whose
    two colours stand for the coefficient itself.
    """

    coefficients: dict[str, Any]
    highlight: str = "halfway"
    boards: dict[str, Board] = field(default_factory=dict)
    fresnel: str = "off"
    metal: bool = False
    """Of the class "metal", whose k_s is what it mirrors straight on."""

    def key(self) -> tuple:
        """The same for equal materials."""
        numbers = ((name, tuple(np.ravel(value).tolist())) for name, value in sorted(self.coefficients.items()))
        words = self.highlight, self.fresnel, self.metal
        return (*numbers, *words, *((name, board.key()) for name, board in sorted(self.boards.items())))


class Found:
    """Objects, materials, lights and cameras by names of their own, and what is lost."""

    def __init__(self, source: str, program: str):
        self.source, self.lost = source, Losses(program)
        self.objects: list[AbstractObject] = []
        self.lights: list[Any] = []
        self.cameras: dict[str, Any] = {}
        self._paints: dict[str, Paint] = {}
        self._known: dict[tuple, str] = {}
        self._taken: set[tuple[str, str]] = set()
        self._counts: dict[tuple[str, str], int] = {}

    def named(self, stated: str | None, kind: str) -> str:
        """A name that no other thing of the kind has, without dots: the stated one, or that of the kind."""
        base = (stated or "").replace(".", "_").strip() or kind
        chosen = base
        while (kind, chosen) in self._taken:
            number = self._counts[kind, base] = self._counts.get((kind, base), 1) + 1
            chosen = f"{base}_{number}"
        self._taken.add((kind, chosen))
        return chosen

    def material(self, paint: Paint, stated: str | None) -> str:
        """The name of a material: of one with the same numbers, if it is there."""
        key = paint.key()
        if key not in self._known:
            self._known[key] = self.named(stated, "material")
            self._paints[self._known[key]] = paint
        return self._known[key]

    def add(self, make: Maker, stated: str | None, kind: str, material: str, place: str) -> None:
        """Add an object. Raises `SceneError` that begins with the place."""
        if len(self.objects) == MOST_OBJECTS:
            raise SceneError(f"{place}: more than {MOST_OBJECTS:,} objects; allowed is fewer")
        name = self.named(stated or kind, "object")
        try:
            self.objects.append(make(name, material))
        except (SceneError, np.linalg.LinAlgError) as error:
            raise SceneError(f"{place}: {error}") from None

    def add_light(self, light, place: str) -> None:
        if len(self.lights) == MOST_LIGHTS:
            raise SceneError(f"{place}: more than {MOST_LIGHTS:,} lights; allowed is fewer")
        self.lights.append(light)

    def scene(self, **settings) -> Scene:
        """The scene, after a note on each thing that is lost. Raises `SceneError` where there is nothing to be seen."""
        if not self.objects:
            raise SceneError(f"{self.source}: there is no shape in it that can be read; allowed is one or more")
        used = {thing.material for thing in self.objects}
        textures: dict[str, Checker] = {}
        materials = {
            name: self._material(name, paint, textures) for name, paint in self._paints.items() if name in used
        }
        for sentence in self.lost:
            warnings.warn(f"{self.source}: {sentence}", SceneNote, stacklevel=4)
        return Scene(
            objects=self.objects,
            materials=materials,
            lights=self.lights,
            cameras=self.cameras,
            textures=textures,
            **settings,
        )

    def _material(self, name: str, paint: Paint, textures: dict[str, Checker]) -> Material:
        """With its boards as textures that multiply coefficients."""
        stated: dict[str, Any] = dict(paint.coefficients)
        wearers = [thing for thing in self.objects if thing.material == name]
        for coefficient, board in paint.boards.items():
            colours = np.asarray(board.colours)
            peak = colours.max(axis=0)
            shares = np.divide(colours, peak, out=np.ones_like(colours), where=peak > 0)
            checker, corner = simplified(board, wearers)
            made = Checker(shares if not checker.swapped else shares[::-1], checker.size, checker.axes)
            if corner.any():
                made = made.moved(corner)
                self.lost.say("where the checkerboard of {} begins is lost in a TOML file", ("material", name))
            same = next((key for key, other in textures.items() if _equal(made, other)), None)
            if same is None:
                same = self.named(f"{name}_tiles", "texture")
                textures[same] = made
            stated[coefficient], stated[f"{coefficient}_texture"] = peak, same
        how: dict[str, Any] = {"fresnel": paint.fresnel}
        if paint.metal:
            own = ("k_s", "k_h", "phong_exponent")
            how, stated = {"class_": "metal"}, {key: value for key, value in stated.items() if key in own}
        return Material(highlight=paint.highlight, place=f"{self.source}: material {name!r}", **how, **stated)  # pyright: ignore[reportArgumentType]


def _equal(one: Checker, other: Checker) -> bool:
    keys = ("colours", "size", "corner")
    alike = (np.allclose(getattr(one, key), getattr(other, key), rtol=1e-6, atol=1e-9) for key in keys)
    return one.axes == other.axes and all(alike)
