"""Scenes as Mitsuba 3 has them, written only."""

from .._format import SceneFormat
from ._scene import mitsuba_scene

MITSUBA = SceneFormat("Mitsuba", (".xml",), write=mitsuba_scene)
