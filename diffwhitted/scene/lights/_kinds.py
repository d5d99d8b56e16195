"""The one list of lights. A new light is a file in this folder and its name here."""

from ...records import Registry
from ._directional import DirectionalLight
from ._light import AbstractLight
from ._point import PointLight
from ._rectangle import RectangleLight
from ._sphere import SphereLight
from ._spot import SpotLight
from ._warn import WarnLight

LIGHTS: Registry[AbstractLight] = Registry(
    "light", AbstractLight, PointLight, DirectionalLight, SpotLight, WarnLight, SphereLight, RectangleLight
)
