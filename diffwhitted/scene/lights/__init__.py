"""Light sources, a kind a file."""

from ._directional import DirectionalLight
from ._kinds import LIGHTS
from ._light import AbstractLight
from ._point import PointLight

__all__ = ["LIGHTS", "AbstractLight", "DirectionalLight", "PointLight"]
