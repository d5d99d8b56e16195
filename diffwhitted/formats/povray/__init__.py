"""Scenes as POV-Ray has them, written only."""

from .._format import SceneFormat
from ._scene import povray_scene

POVRAY = SceneFormat("POV-Ray", (".pov",), write=povray_scene)
