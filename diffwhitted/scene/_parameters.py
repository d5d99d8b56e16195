"""Names of numbers: what a scene holds, a name for each of them, reading and replacing.

    glass.k_d   material.glass.k_d   light.key.colour.r   object.ball.centre.x   object.roof.vertices.2.y
    camera.main.look_from   texture.tiles.colours.0.r   texture.tiles.size   scene.ambient   background.top.b

The family word comes first; a name without one is a material's. What numbers a record has, its rows say, so that a new
kind of light or shape has its names by itself.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from .._errors import SceneError
from ..records import Row, changed, is_traced
from ._again import check_again
from ._coefficients import coefficients
from ._material import checked
from ._scene import Scene
from ._settings import settings_of

FAMILIES = ("light", "object", "camera", "texture", "shot")
"""The families whose members have names, beside the materials."""
WITHOUT_NAME = ("scene", "background")
"""The family words that are followed by the key itself."""
Index = tuple[int, ...]


@dataclass(frozen=True)
class Parameter:
    """What a name stands for: one key of one record of a scene, a number or several; hashable."""

    family: str
    """"material", "light", "object", "camera", "texture", "shot", "scene" or "background"."""
    owner: str
    """The name of the record; of the last two families empty, or the key of [scene] that is a record itself."""
    row: Row
    """Its unit, interval, scale, and what a change of it moves."""

    @property
    def name(self) -> str:
        """Such as "light.key.colour"; of a material without the family word."""
        if self.family in WITHOUT_NAME:
            return ".".join(filter(None, (self.family, self.owner, self.row.name)))
        return f"{'' if self.family == 'material' else f'{self.family}.'}{self.owner}.{self.row.name}"

    @property
    def place(self) -> str:
        """The record, as messages call it."""
        if self.family in WITHOUT_NAME:
            return ": ".join(filter(None, (self.family, self.owner)))
        return f"{self.family} {self.owner!r}"

    def value(self, scene: Scene):
        """Its value; an absent k_h reads as k_s."""
        if self.family == "material":
            return scene.materials[self.owner].at_work(self.row.name)
        return getattr(self.record(scene), self.row.name)

    def replaced(self, scene: Scene, value) -> Scene:
        """The scene with another value; differentiable. Raises `SceneError` for a wrong shape or a value that is not
        allowed.
        """
        if self.family == "material":
            array = checked(self.row.name, value, self.place)
        else:
            array = self.row.read(value, self.place)
            if jnp.shape(array) != jnp.shape(self.value(scene)):
                allowed = jnp.shape(self.value(scene))
                raise SceneError(f"{self.place}: {self.row.name} has shape {array.shape}; allowed is {allowed}")
        if is_traced(array) or not (scene.keeps_digits and self.family in FAMILIES):
            array = array.astype(scene.dtype)
        match self.family:
            case "material":
                record = scene.materials[self.owner]
                new = changed(record, values={**record.values, self.row.name: array})
                return changed(scene, materials={**scene.materials, self.owner: new})
            case "scene":
                new = {self.row.name: array}
                return changed(scene, **({self.owner: changed(self.record(scene), **new)} if self.owner else new))
        record = self.record(scene)
        # Texels that are replaced are no longer those of a file.
        gone = {"file": None, "encoding": None} if self.row.kind == "texels" else {}
        new = changed(record, **{self.row.name: array}, **gone)
        if not any(map(is_traced, jax.tree.leaves(new))):
            check_again(new, self.place)
        if self.family == "background":
            return changed(scene, background=new)
        field, held = self._held(scene)
        if isinstance(held, Mapping):
            return changed(scene, **{field: {**held, self.owner: new}})
        return changed(scene, **{field: tuple(new if thing is record else thing for thing in held)})

    def components(self, scene: Scene) -> tuple[str, ...]:
        """The names of its numbers within it, such as "r" or "2.y"; none where it is one number."""
        return self.row.components(jnp.shape(self.value(scene)))

    def index(self, scene: Scene, component: str) -> Index:
        """Where a component lies in the value. Raises `SceneError` where there is none of that name."""
        names = self.components(scene)
        if component not in names:
            grey = self.row.coloured and not names and component in ("r", "g", "b")
            there = (
                f"in the scene {self.row.name} is one number, the same for all channels. Write three numbers there, "
                f"such as {self.row.name} = [{', '.join([f'{float(self.value(scene)):g}'] * 3)}]"
                if grey and not is_traced(self.value(scene))
                else f"there is {', '.join(names)}"
                if names
                else "it is one number"
            )
            raise SceneError(f"{self.name}.{component}: {self.name} has no component {component!r}; {there}")
        return tuple(map(int, np.unravel_index(names.index(component), jnp.shape(self.value(scene)))))

    def _held(self, scene: Scene):
        """The field of the scene that holds the family, and what is there."""
        field = f"{self.family}s"
        return field, getattr(scene, field)

    def record(self, scene: Scene):
        """What holds it: a light, an object, a camera, ..., or the scene itself."""
        if self.family in WITHOUT_NAME:
            held = scene if self.family == "scene" else scene.background
            return getattr(held, self.owner) if self.owner else held
        return scene.materials[self.owner] if self.family == "material" else members(scene, self.family)[self.owner]


def parameters(scene: Scene) -> tuple[Parameter, ...]:
    """All numbers of a scene that have a name, family by family, materials first.

    Left out is what is not there (an attenuation that is not stated) and what belongs to an object, camera or texture
    whose name has a dot in it.
    """
    return tuple(_all(scene))


def maps(scene: Scene) -> tuple[Parameter, ...]:
    """The texels of each picture that a scene holds, such as "texture.wall.texels": an array under one name, whose
    numbers have none.
    """
    return tuple(
        Parameter(family, name, row)
        for family in FAMILIES
        for name, record in members(scene, family).items()
        for row in texels_of(record)
        if "." not in name
    )


def _all(scene: Scene) -> Iterator[Parameter]:
    for name in scene.materials:
        yield from (Parameter("material", name, row) for row in coefficients() if scene.materials[name].has(row.name))
    for family in FAMILIES:
        for name, record in members(scene, family).items():
            if "." not in name:
                yield from (Parameter(family, name, row) for row in numbers_of(record))
    yield from (Parameter("scene", owner, row) for owner, row in settings_of(scene))
    yield from (Parameter("background", "", row) for row in numbers_of(scene.background))


def members(scene: Scene, family: str) -> Mapping:
    """The records of a family by name."""
    held = getattr(scene, f"{family}s")
    return held if isinstance(held, Mapping) else {thing.name: thing for thing in held}


def numbers_of(record) -> Iterator[Row]:
    """The rows of what a record holds in numbers."""
    return (row for row in record.ROWS if row.numeric and getattr(record, row.name) is not None)


def texels_of(record) -> Iterator[Row]:
    return (row for row in record.ROWS if row.kind == "texels")
