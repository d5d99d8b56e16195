"""A differentiable Whitted ray tracer.

    scene = diffwhitted.load_scene("scene.toml")
    image = diffwhitted.render(scene, scene.cameras["main"])        # (height, width, 3), linear RGB

The image is a differentiable function of every number in the scene; materials are replaced by name with
`replace_coefficient`. Fits live in the package `fitting`.

Conventions. Right-handed, y up. Metres; radians, except where a name ends in `_deg`. Directions have unit
length and point away from the surface, except the incoming ray, which points along its travel. Images are
(height, width, 3), row 0 on top, linear Rec. 709 RGB, scene-referred: nothing is clipped before display.
The precision of a scene is that of its arrays, float32 unless it is made or loaded with
`precision="float64"`.
"""

from typing import TYPE_CHECKING

from . import display as display
from ._errors import CapacityError, FarFromOrigin, InputError, SceneError
from ._lazily import lazily
from ._radiosity import PatchLight, radiosity
from ._render import plan, render
from .accuracy import KNOBS, Choice, Knob, Measured, Settings, choose, measure
from .cost import Explanation, RayMaps, explain, ray_maps
from .rendering._antialias import Antialiased, antialias
from .rendering._derivative import Derivative, derivative
from .rendering._layers import Layers, layers
from .rendering._render_with_bound import Bounded, render_with_bound
from .scene import (
    COEFFICIENTS,
    Box,
    Camera,
    Checker,
    Cone,
    ConstantBackground,
    Cylinder,
    Dimples,
    DirectionalLight,
    Disc,
    EnvironmentBackground,
    GradientBackground,
    HarmonicBackground,
    Hemisphere,
    ImageTexture,
    Material,
    Mesh,
    Noise,
    OrthographicCamera,
    Parameter,
    Patch,
    Plane,
    PointLight,
    Polygon,
    Polyhedron,
    Quadric,
    RectangleLight,
    Scene,
    Shot,
    Sphere,
    SphereLight,
    SphereSet,
    SpotLight,
    Torus,
    WarnLight,
    Waves,
    coefficient_value,
    parameter_value,
    parameters,
    replace_coefficient,
    replace_parameter,
)
from .tree import Effects, Plan, decide_effects

if TYPE_CHECKING:
    from .formats import load_scene, parse_scene, read_cameras, save_scene, scene_schema
    from .image import read_image, write_image
    from .standard import standard_scene

__all__ = [
    "Antialiased",
    "Bounded",
    "Box",
    "COEFFICIENTS",
    "Camera",
    "CapacityError",
    "Checker",
    "Choice",
    "Cone",
    "ConstantBackground",
    "Cylinder",
    "Derivative",
    "Dimples",
    "DirectionalLight",
    "Disc",
    "Effects",
    "EnvironmentBackground",
    "Explanation",
    "FarFromOrigin",
    "GradientBackground",
    "HarmonicBackground",
    "Hemisphere",
    "ImageTexture",
    "InputError",
    "KNOBS",
    "Knob",
    "Layers",
    "Material",
    "Measured",
    "Mesh",
    "Noise",
    "OrthographicCamera",
    "Parameter",
    "Plan",
    "Patch",
    "PatchLight",
    "Plane",
    "PointLight",
    "Polygon",
    "Polyhedron",
    "Quadric",
    "RayMaps",
    "RectangleLight",
    "Scene",
    "SceneError",
    "Settings",
    "Shot",
    "Sphere",
    "SphereLight",
    "SphereSet",
    "SpotLight",
    "Torus",
    "WarnLight",
    "Waves",
    "antialias",
    "choose",
    "coefficient_value",
    "decide_effects",
    "derivative",
    "explain",
    "layers",
    "load_scene",
    "measure",
    "parameter_value",
    "parameters",
    "parse_scene",
    "plan",
    "radiosity",
    "ray_maps",
    "read_cameras",
    "read_image",
    "render",
    "render_with_bound",
    "replace_coefficient",
    "replace_parameter",
    "save_scene",
    "scene_schema",
    "standard_scene",
    "write_image",
]

__getattr__ = lazily(
    __name__,
    dict.fromkeys(("load_scene", "parse_scene", "read_cameras", "save_scene", "scene_schema"), "formats")
    | dict.fromkeys(("read_image", "write_image"), "image")
    | {"standard_scene": "standard"},
)
"""Schemas of scene files, libraries of pictures and standard scenes wait until they are asked for."""
