"""Scenes as glTF 2.0 has them, read and written."""

from .._format import SceneFormat
from ._read import parse_gltf
from ._scene import gltf_scene

GLTF = SceneFormat("glTF", (".gltf",), parse=parse_gltf, write=gltf_scene)
"""A whole scene as one glTF 2.0 file: meshes, materials, cameras, lights."""
GLB = SceneFormat("GLB", (".glb",), parse=parse_gltf)
"""The same in bytes, read only."""
