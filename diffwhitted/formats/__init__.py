"""Scene files, in and out; a file per format."""

from .toml._reading import load_scene, parse_scene, save_scene, scene_text
from .toml._schema import scene_schema

__all__ = ["load_scene", "parse_scene", "save_scene", "scene_schema", "scene_text"]
