"""What a ray sees that meets nothing, a kind a file."""

from ._background import AbstractBackground
from ._constant import ConstantBackground
from ._gradient import GradientBackground
from ._kinds import BACKGROUNDS

__all__ = ["BACKGROUNDS", "AbstractBackground", "ConstantBackground", "GradientBackground"]
