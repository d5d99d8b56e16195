"""What is there: inert records of objects, materials, lights and cameras."""

from ..records import DEEPEST, Row, depth_number, is_traced, nearest_name, shortest, whole_number
from ..shapes import (
    OBJECTS,
    POSE,
    AbstractObject,
    Box,
    Cone,
    Cylinder,
    Disc,
    Mesh,
    Patch,
    Plane,
    Polygon,
    Polyhedron,
    Quadric,
    Sphere,
    SphereSet,
    Torus,
)
from ._classes import CLASS_NAMES, CLASSES, FresnelModel
from ._coefficients import BY_NAME, COEFFICIENTS, SWITCHED, coefficients, including_coefficient
from ._hemisphere import Ambient, Hemisphere, most_ambient
from ._interreflection import Interreflection
from ._material import (
    CHOICES,
    FRESNEL_MODELS,
    HIGHLIGHTS,
    MOST_ROUGHNESS_SAMPLES,
    ROUGHNESS_SAMPLES,
    HighlightModel,
    Material,
    highest_coat,
    textured_rows,
)
from ._names import coefficient_value, replace_coefficient
from ._naming import find_parameter, parameter_value, replace_parameter
from ._near import near
from ._parameters import FAMILIES, WITHOUT_NAME, Parameter, maps, parameters
from ._patch_light import Lightmap, brightest_patch, patch_light, patches_in
from ._relief import RELIEFS
from ._scene import DISTANCE_FADE, Precision, Scene, ShadowModel, TotalReflection, check_footprint, float_dtype
from ._sheets import Sheet, shared_sheets
from ._shot import TEXTS, PixelFilter, Shot, from_middle
from ._tables import Marks, Tables, marks_of, material_names, numbered_objects, tabled_lights, tabulate, texture_names
from .backgrounds import (
    BACKGROUNDS,
    AbstractBackground,
    ConstantBackground,
    EnvironmentBackground,
    GradientBackground,
    HarmonicBackground,
)
from .cameras import BLUR_SAMPLES, CAMERAS, MOST_BLUR_SAMPLES, VIEW, AbstractCamera, Camera, OrthographicCamera
from .lights import (
    LIGHTS,
    MOST_SAMPLES,
    AbstractLight,
    Border,
    DirectionalLight,
    PointLight,
    RectangleLight,
    SphereLight,
    SpotLight,
    WarnLight,
)
from .textures import TEXTURES, AbstractTexture, Checker, Dimples, ImageTexture, Noise, TexturePoint, Waves

__all__ = [
    "AbstractBackground", "AbstractCamera", "AbstractLight", "AbstractObject", "AbstractTexture", "Ambient",
    "BACKGROUNDS", "BLUR_SAMPLES", "BY_NAME", "Border", "Box", "CAMERAS", "CHOICES", "CLASSES", "CLASS_NAMES",
    "COEFFICIENTS", "Camera", "Checker", "Cone", "ConstantBackground", "Cylinder", "DEEPEST", "DISTANCE_FADE",
    "Dimples", "DirectionalLight", "Disc", "EnvironmentBackground", "FAMILIES", "FRESNEL_MODELS", "FresnelModel",
    "GradientBackground", "HIGHLIGHTS", "HarmonicBackground", "Hemisphere", "HighlightModel", "ImageTexture",
    "Interreflection", "LIGHTS", "Lightmap", "MOST_BLUR_SAMPLES", "MOST_ROUGHNESS_SAMPLES", "MOST_SAMPLES", "Marks",
    "Material", "Mesh", "Noise", "OBJECTS", "OrthographicCamera", "POSE", "Parameter", "Patch", "PixelFilter", "Plane",
    "PointLight", "Polygon", "Polyhedron", "Precision", "Quadric", "RELIEFS", "ROUGHNESS_SAMPLES", "RectangleLight",
    "Row", "Scene", "ShadowModel", "Sheet", "Shot", "Sphere", "SphereLight", "SphereSet", "SWITCHED", "SpotLight",
    "TEXTS", "TEXTURES", "Tables", "TexturePoint", "Torus", "TotalReflection", "VIEW", "WITHOUT_NAME", "WarnLight",
    "Waves", "brightest_patch", "check_footprint", "coefficient_value", "coefficients", "depth_number",
    "find_parameter", "float_dtype", "from_middle", "highest_coat", "including_coefficient", "is_traced", "maps",
    "marks_of", "material_names", "most_ambient", "near", "nearest_name", "numbered_objects", "parameter_value",
    "parameters", "patch_light", "patches_in", "replace_coefficient", "replace_parameter", "shared_sheets", "shortest",
    "tabled_lights", "tabulate", "texture_names", "textured_rows", "whole_number",
]  # fmt: skip
