"""Scenes as Mitsuba 3 has them, written and read."""

from .._format import SceneFormat
from ._read import parse_mitsuba
from ._scene import mitsuba_scene

MITSUBA = SceneFormat("Mitsuba", (".xml",), parse=parse_mitsuba, write=mitsuba_scene)
