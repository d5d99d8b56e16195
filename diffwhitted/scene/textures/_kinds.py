"""The one list of textures. A new texture is a file in this folder and its name here."""

from ...records import Registry
from ._checker import Checker
from ._dimples import Dimples
from ._image import ImageTexture
from ._noise import Noise
from ._texture import AbstractTexture
from ._waves import Waves

TEXTURES: Registry[AbstractTexture] = Registry("texture", AbstractTexture, Checker, ImageTexture, Noise, Waves, Dimples)
