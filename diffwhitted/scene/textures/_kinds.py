"""The one list of textures. A new texture is a file in this folder and its name here."""

from ...records import Registry
from ._checker import Checker
from ._image import ImageTexture
from ._texture import AbstractTexture

TEXTURES: Registry[AbstractTexture] = Registry("texture", AbstractTexture, Checker, ImageTexture)
