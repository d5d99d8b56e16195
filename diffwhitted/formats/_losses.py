"""What a format cannot say: sentences, each once, in the order in which they were met."""

import inspect
import json
from collections.abc import Collection, Iterator

import numpy as np

from .._errors import printable
from ..scene import Material, Scene, coefficients

Thing = tuple[str, str]
"""Of what a sentence is said: its kind and its name, such as ("material", "glass")."""
_NEVER = {"self", "place", "name", "material", "precision"}
_MEMBERS = {"objects", "materials", "lights", "cameras", "textures", "background", "shots"}
_DRAWING = {"footprint"}
"""How this program draws, and nothing of the scene."""


class Losses:
    """The sentences on what one file does not say."""

    def __init__(self, format_name: str):
        self._name = format_name
        self._said: dict[tuple[str, str], dict[str, None]] = {}

    def say(self, sentence: str, what: Thing | None = None) -> None:
        """Add a sentence; where `{}` stands in it, all things of which it is said are named."""
        kind, name = what or ("", "")
        self._said.setdefault((sentence, kind), {})[name] = None

    def unknown(self, record, known: Collection[str], what: Thing) -> None:
        """Say which keys of a record the format has no word for, and the record states."""
        for key in _stated(record, known):
            self.say(f"{key} of {{}} is lost", what)

    def unknown_settings(self, scene: Scene, known: Collection[str]) -> None:
        """The same of the table [scene]."""
        for key in _stated(scene, {*known, *_MEMBERS, *_DRAWING}):
            self.say(f"{key} of the scene is lost")
        self.shots(scene)

    def shots(self, scene: Scene) -> None:
        """Say that the shots are, where there are any."""
        if scene.shots:
            self.say(f"left out: what the scene says of its pictures ({len(scene.shots)} in [[shot]])")

    def unknown_coefficients(self, material: Material, known: Collection[str], what: Thing) -> None:
        """Say which coefficients the format has no word for, where they do anything."""
        for row in coefficients():
            value = material.values.get(row.name)
            if row.name not in known and value is not None and not _same(value, row.default):
                self.say(f"{row.name} of {{}} is lost", what)
        self.unknown_choices(material, known, what)

    def unknown_choices(self, material: Material, known: Collection[str], what: Thing) -> None:
        """Say which words of a material the format has none for: class, model of the angle, what bends normals."""
        if "fresnel" not in known and material.fresnel != "off":
            self.say("fresnel of {} is lost: its weights do not hang on the angle", what)
        for key, worn in material.relief:
            if key not in known:
                self.say(f"{key} {named(worn)} of {{}} is lost", what)
        self.unknown(material, {"highlight", "fresnel", *known, *material.left_out()}, what)

    def __iter__(self) -> Iterator[str]:
        return (f"{self._name}: {sentence}" for sentence in self.here())

    def here(self) -> list[str]:
        """The sentences as they stand in the file itself, without the name of the format."""
        return [_whole(sentence, kind, list(names)) for (sentence, kind), names in self._said.items()]


def named(name: str) -> str:
    """The name of a thing in quotes, on one line, whatever is in it."""
    return json.dumps(printable(name), ensure_ascii=False)


def _whole(sentence: str, kind: str, names: list[str]) -> str:
    if not kind:
        return sentence
    return sentence.replace("{}", f"{kind}{'s' * (len(names) > 1)} {', '.join(map(named, names))}")


def _stated(record, known: Collection[str]) -> Iterator[str]:
    """The keys that a record takes beyond the known ones and whose values are not their defaults."""
    for key, parameter in inspect.signature(type(record).__init__).parameters.items():
        if key in known or key in _NEVER or parameter.kind is parameter.VAR_KEYWORD:
            continue
        value = getattr(record, key, parameter.default)
        if parameter.default is parameter.empty or not _same(value, parameter.default):
            yield key.rstrip("_")


def _same(value, default) -> bool:
    if value is None or default is None:
        return value is default
    if isinstance(default, str):
        return value == default
    return np.shape(value) in (np.shape(default), ()) and np.array_equal(
        np.asarray(value), np.asarray(default, np.asarray(value).dtype)
    )
