"""Scene files, in and out; a format a file or a folder."""

from ._format import SceneFormat
from ._kinds import FORMATS, format_of, including_format
from ._load import load_scene, save_scene
from .cameras import read_cameras
from .toml._reading import parse_scene, scene_text
from .toml._schema import scene_schema

__all__ = [
    "FORMATS", "SceneFormat", "format_of", "including_format", "load_scene", "parse_scene", "read_cameras",
    "save_scene", "scene_schema", "scene_text",
]  # fmt: skip
