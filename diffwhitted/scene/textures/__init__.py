"""Patterns that multiply a coefficient, a kind a file."""

from ._checker import Checker
from ._kinds import TEXTURES
from ._texture import AbstractTexture

__all__ = ["TEXTURES", "AbstractTexture", "Checker"]
