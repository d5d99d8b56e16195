"""Scenes as TOML: what a file may say, what is wrong with one, reading and writing."""

from .._format import SceneFormat
from ._reading import parse_bytes, scene_text

TOML = SceneFormat(
    "TOML", (".toml",), parse_bytes, lambda scene, source: scene_text(scene, source=source).encode("utf-8")
)
