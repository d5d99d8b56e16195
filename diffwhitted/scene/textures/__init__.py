"""Patterns that multiply a coefficient, a kind a file."""

from ._checker import Checker
from ._image import ImageTexture
from ._kinds import TEXTURES
from ._texture import AbstractTexture, TexturePoint

__all__ = ["TEXTURES", "AbstractTexture", "Checker", "ImageTexture", "TexturePoint"]
