"""Scenes as glTF 2.0 has them, written only."""

from .._format import SceneFormat
from ._scene import gltf_scene

GLTF = SceneFormat("glTF", (".gltf",), write=gltf_scene)
