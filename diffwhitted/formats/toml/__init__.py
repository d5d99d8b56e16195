"""Scenes as TOML: what a file may say, what is wrong with one, reading and writing."""

from pathlib import Path

from .._format import SceneFormat
from ._reading import parse_bytes, scene_text

TOML = SceneFormat(
    "TOML",
    (".toml",),
    parse_bytes,
    lambda scene, path: scene_text(scene, source=path, folder=Path(path).parent).encode("utf-8"),
)
