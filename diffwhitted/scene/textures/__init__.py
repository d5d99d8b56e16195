"""Patterns that multiply a coefficient or bend the normal, a kind a file."""

from ._checker import Checker
from ._dimples import Dimples
from ._image import ImageTexture
from ._kinds import TEXTURES
from ._noise import Noise
from ._texture import AbstractTexture, TexturePoint
from ._waves import Waves

__all__ = ["TEXTURES", "AbstractTexture", "Checker", "Dimples", "ImageTexture", "Noise", "TexturePoint", "Waves"]
