"""Scene files, in and out; a format a file or a folder."""

from ._beside import with_files
from ._format import SceneFormat, Written
from ._kinds import FORMATS, format_of, including_format
from ._load import load_scene, save_scene, write_file
from ._tables import latex_table, markdown_table, plain_words
from .cameras import read_cameras
from .toml._reading import parse_scene, scene_text
from .toml._schema import scene_schema

__all__ = [
    "FORMATS", "SceneFormat", "Written", "format_of", "including_format", "latex_table", "load_scene",
    "markdown_table", "parse_scene", "plain_words", "read_cameras", "save_scene", "scene_schema", "scene_text",
    "with_files", "write_file",
]  # fmt: skip
