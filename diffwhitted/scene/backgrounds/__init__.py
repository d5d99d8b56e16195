"""What a ray sees that meets nothing, a kind a file."""

from ._background import AbstractBackground
from ._constant import ConstantBackground
from ._environment import EnvironmentBackground
from ._gradient import GradientBackground
from ._harmonics import HarmonicBackground
from ._kinds import BACKGROUNDS
from ._surroundings import Surroundings

__all__ = [
    "BACKGROUNDS", "AbstractBackground", "ConstantBackground", "EnvironmentBackground", "GradientBackground",
    "HarmonicBackground", "Surroundings",
]  # fmt: skip
