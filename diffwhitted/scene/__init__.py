"""What is there: inert records of objects, materials, lights and cameras."""

from ._background import Background, ConstantBackground, GradientBackground
from ._camera import Camera
from ._checks import DEEPEST, depth_number, is_traced, nearest_name, shortest, whole_number
from ._coefficients import BY_NAME, COEFFICIENTS, Coefficient
from ._lights import DirectionalLight, Light, PointLight
from ._material import HighlightModel, Material
from ._names import coefficient_value, replace_coefficient, split_name
from ._objects import Object, Plane, Polygon, Sphere
from ._scene import Precision, Scene, ShadowModel, TotalReflection, check_footprint, float_dtype
from ._tables import MaterialTable, Tables, material_names, numbered_objects, tabulate, texture_names
from ._textures import Checker, Texture

__all__ = [
    "BY_NAME",
    "COEFFICIENTS",
    "DEEPEST",
    "Background",
    "Camera",
    "Checker",
    "Coefficient",
    "ConstantBackground",
    "DirectionalLight",
    "GradientBackground",
    "HighlightModel",
    "Light",
    "Material",
    "MaterialTable",
    "Object",
    "Plane",
    "PointLight",
    "Polygon",
    "Precision",
    "Scene",
    "ShadowModel",
    "Sphere",
    "Tables",
    "Texture",
    "TotalReflection",
    "check_footprint",
    "coefficient_value",
    "depth_number",
    "is_traced",
    "float_dtype",
    "material_names",
    "nearest_name",
    "numbered_objects",
    "replace_coefficient",
    "shortest",
    "split_name",
    "tabulate",
    "texture_names",
    "whole_number",
]
