"""Scenes as POV-Ray has them, written and read."""

from .._format import SceneFormat
from ._read import parse_povray
from ._scene import povray_scene

POVRAY = SceneFormat("POV-Ray", (".pov",), parse=parse_povray, write=povray_scene)
