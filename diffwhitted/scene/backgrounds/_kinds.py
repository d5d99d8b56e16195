"""The one list of backgrounds. A new background is a file in this folder and its name here."""

from ...records import Registry
from ._background import AbstractBackground
from ._constant import ConstantBackground
from ._environment import EnvironmentBackground
from ._gradient import GradientBackground
from ._harmonics import HarmonicBackground

BACKGROUNDS: Registry[AbstractBackground] = Registry(
    "background", AbstractBackground, ConstantBackground, GradientBackground, EnvironmentBackground, HarmonicBackground
)
