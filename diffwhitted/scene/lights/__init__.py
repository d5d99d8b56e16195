"""Light sources, a kind a file."""

from ._border import Border
from ._directional import DirectionalLight
from ._kinds import LIGHTS
from ._light import AbstractLight
from ._point import PointLight
from ._rectangle import RectangleLight
from ._sphere import SphereLight
from ._spot import SpotLight
from ._spread import MOST_SAMPLES
from ._warn import WarnLight

__all__ = [
    "AbstractLight", "Border", "DirectionalLight", "LIGHTS", "MOST_SAMPLES", "PointLight", "RectangleLight",
    "SphereLight", "SpotLight", "WarnLight",
]  # fmt: skip
