"""Scene files, in and out; a file per format."""

from ._schema import scene_schema
from ._toml import load_scene, parse_scene, save_scene, scene_text

__all__ = ["load_scene", "parse_scene", "save_scene", "scene_schema", "scene_text"]
