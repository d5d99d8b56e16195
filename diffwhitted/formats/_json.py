"""Every number of a scene by its name, as JSON, written only."""

import inspect
import json
from typing import Any

import numpy as np

from ..records import rows_of
from ..scene import Scene, parameters
from ._format import SceneFormat, Written
from ._losses import Losses, named
from ._numbers import plain

VERSION = 1
SHOT = ("camera", "picture", "mask", "encoding", "lights", "noise", "filter")
"""What a shot says in words and settings."""


def json_numbers(scene: Scene, source: str) -> Written:
    """`parameters` by the names of `diffwhitted.parameters`, each with value, unit and meaning; and what each thing is
    called, made of and chosen to be.
    """
    del source
    lost = Losses("JSON")
    for family in ("object", "camera", "texture"):
        members = getattr(scene, f"{family}s")
        for name in members if isinstance(members, dict) else [thing.name for thing in members]:
            if "." in name:
                lost.say(f"the numbers of {family} {named(name)} are left out, as its name has a dot in it")
    content = {
        "format": "diffwhitted numbers",
        "version": VERSION,
        "precision": scene.precision,
        "parameters": {p.name: _number(scene, p) for p in parameters(scene)},
        "settings": _settings(scene),
        "background": {"type": scene.background.written_type(), **_words(scene.background)},
        "materials": {
            name: {
                "class": material.class_,
                "highlight": material.highlight,
                "fresnel": material.fresnel,
                "fresnel_highlight": material.fresnel_highlight,
                "textures": dict(material.textures),
                "relief": dict(material.relief),
                "dispersion": material.dispersion,
                "roughness_samples": material.roughness_samples,
                "k_h_is_k_s": material.values["k_h"] is None,
            }
            for name, material in scene.materials.items()
        },
        "objects": {o.name: {"type": o.written_type(), "material": o.material, **_words(o)} for o in scene.objects},
        "lights": {light.name: {"type": light.written_type(), **_words(light)} for light in scene.lights},
        "textures": {name: {"type": t.written_type(), **_words(t)} for name, t in scene.textures.items()},
        "cameras": {
            name: {"type": c.written_type(), **_stated(c.keys()), **_words(c)} for name, c in scene.cameras.items()
        },
        "shots": {shot.name: _stated({key: getattr(shot, key) for key in SHOT}) for shot in scene.shots},
        "not_in_this_file": lost.here(),
    }
    return Written(
        (json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8", "backslashreplace"),
        tuple(lost),
    )


def _number(scene: Scene, parameter) -> dict[str, Any]:
    row = parameter.row
    about = {"value": plain(parameter.value(scene)).tolist(), "unit": row.unit, "meaning": row.meaning}
    return about | ({"symbol": row.symbol} if row.symbol else {})


def _stated(keys: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in keys.items() if value is not None}


def _words(record) -> dict[str, Any]:
    """What a record says in words rather than numbers."""
    words = {
        name: getattr(record, name) for name, row in rows_of(record).items() if not row.numeric and row.kind != "texels"
    }
    return {
        name: np.asarray(value).tolist() if name == "matrix" else value
        for name, value in words.items()
        if value is not None
    }


def _settings(scene: Scene) -> dict[str, Any]:
    """What the table [scene] says in words and counts, and the cutoff."""
    keys = inspect.signature(Scene.__init__).parameters
    stated = {key: getattr(scene, key, None) for key in keys}
    return {key: value for key, value in stated.items() if isinstance(value, (str, int)) and key != "precision"} | {
        "cutoff": float(plain(np.asarray(scene.cutoff)))
    }


JSON = SceneFormat("JSON", (".json",), write=json_numbers)
