"""Scenes as "The Ray Tracer Challenge" (J. Buck, 2019) has them in YAML, read only."""

from .._format import SceneFormat
from ._read import parse_challenge

CHALLENGE = SceneFormat("The Ray Tracer Challenge", (".yml", ".yaml"), parse=parse_challenge)
