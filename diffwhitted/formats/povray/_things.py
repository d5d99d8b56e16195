"""Objects, lights, cameras and backgrounds in POV-Ray's words, a function a kind."""

from collections.abc import Callable
from math import ceil

import numpy as np

from ...scene import (
    Camera,
    ConstantBackground,
    DirectionalLight,
    GradientBackground,
    OrthographicCamera,
    Plane,
    PointLight,
    Polygon,
    RectangleLight,
    Scene,
    Sphere,
    SphereLight,
    SpotLight,
    WarnLight,
)
from .._losses import Losses
from .._numbers import extent, plain, rgb, text
from .._views import aside, axes_of, box, frustum
from ._many import MANY
from ._solids import SOLIDS
from ._words import colour, place

FAR = 1e5
"""How many times the size of the scene a light at infinity is away."""
NEAR = 1e-3
"""Part of the size of the scene at which a light that fades from its very place is at twice its colour."""


ROUND = 9
"""Points along the sides of the disc that stands for a ball which one ray looks at."""
Fading = PointLight | SpotLight | WarnLight | SphereLight | RectangleLight


def sphere(thing: Sphere) -> str:
    return f"sphere {{ {place(plain(thing.centre))}, {text(float(plain(thing.radius)))}"


def plane(thing: Plane) -> str:
    normal = plain(thing.normal)
    size = float(np.linalg.norm(normal))
    return f"plane {{ {place(normal / size)}, {text(float(plain(thing.offset)) / size)}"


def polygon(thing: Polygon) -> str:
    corners = [place(vertex) for vertex in plain(thing.vertices)]
    if len(corners) == 3:
        return f"triangle {{ {', '.join(corners)}"
    return f"polygon {{ {len(corners) + 1}, {', '.join([*corners, corners[0]])}"


SHAPES: dict[type, Callable[..., str]] = {Sphere: sphere, Plane: plane, Polygon: polygon, **SOLIDS, **MANY}
"""A kind of shape is a function here: the beginning of its statement, up to the texture."""


def point_light(light: PointLight, scene: Scene, lost: Losses) -> str:
    shade, fade = _fade(light, scene, lost)
    return f"light_source {{ {place(plain(light.position))} {colour(shade)}{fade} }}"


def spot_light(light: SpotLight | WarnLight, scene: Scene, lost: Losses) -> str:
    """POV-Ray's cone is s^2 (3 - 2 s) in the cosine too, its tightness the exponent; behind the lamp is no light."""
    (shade, fade), what = _fade(light, scene, lost), ("light", light.name or "")
    if any(getattr(light, name, None) is not None for name in ("flaps_x", "flaps_y", "flaps_z")):
        lost.say("the flaps of {} are lost", what)
    outer, inner, tight = (
        None if value is None else float(plain(value))
        for value in (light.cone_deg, light.inner_cone_deg, light.exponent)
    )
    if outer is None and not tight:
        return f"light_source {{ {place(plain(light.position))} {colour(shade)}{fade} }}"
    if outer is None or outer > 90:
        outer = 90.0
        if not tight:
            lost.say("the cone of {} ends at 90 degrees, as POV-Ray's does", what)
    inner = outer if inner is None else min(inner, outer)
    axis = light.axis()
    aim = plain(light.position) + np.asarray([float(part) for part in (axis.x, axis.y, axis.z)])
    cone = f"spotlight point_at {place(aim)} radius {text(inner)} falloff {text(outer)} tightness {text(tight or 0)}"
    return f"light_source {{ {place(plain(light.position))} {colour(shade)} {cone}{fade} }}"


def rectangle_light(light: RectangleLight, scene: Scene, lost: Losses) -> str:
    """POV-Ray's points reach from edge to edge: a grid within the edges by half a cell is one of middles of cells."""
    count = ceil(light.samples**0.5)
    if count**2 != light.samples:
        lost.say(f"the points of {{}} are a grid of {count} x {count}", ("light", light.name or ""))
    u, v = plain(light.edge_u), plain(light.edge_v)
    grid = f"{place(u * (count - 1) / count)}, {place(v * (count - 1) / count)}, {count}, {count}"
    return _spread(light, plain(light.corner) + (u + v) / 2, grid, scene, lost)


def sphere_light(light: SphereLight, scene: Scene, lost: Losses) -> str:
    count = ceil(light.samples**0.5) or ROUND
    lost.say(f"{{}} is a disc of {count} x {count} points that faces what it shines at", ("light", light.name or ""))
    across = 2 * float(plain(light.radius)) * (count - 1) / count
    grid = f"{place(np.eye(3)[0] * across)}, {place(np.eye(3)[1] * across)}, {count}, {count} circular orient"
    return _spread(light, plain(light.centre), grid, scene, lost)


def _spread(light: RectangleLight | SphereLight, middle: np.ndarray, grid: str, scene: Scene, lost: Losses) -> str:
    shade, fade = _fade(light, scene, lost)
    return f"light_source {{ {place(middle)} {colour(shade)} area_light {grid} area_illumination on{fade} }}"


def _fade(light: Fading, scene: Scene, lost: Losses) -> tuple[np.ndarray, str]:
    """The colour, and the words for how it gets less with the distance."""
    shade = rgb(light.colour)
    if light.attenuation is None:
        return shade, ""
    # 2 / (1 + (d / fade_distance)^fade_power) is all that POV-Ray has.
    a0, a1, a2 = plain(light.attenuation)
    near = NEAR * extent(scene)[1]
    power, factor = (2, a2) if a2 else (1, a1)
    what = ("light", light.name or "")
    if a1 and a2:
        lost.say(f"attenuation of {{}}: a1 = {text(a1)} is lost, as POV-Ray fades by one power of the distance", what)
    if a0 < 1 and light.held:
        lost.say("attenuation of {}: POV-Ray goes on above 1 where the light is near, where it ends at 1 here", what)
    if not factor:
        return shade * (min(1.0, 1 / a0) if light.held else 1 / a0), ""
    start = a0 or factor * near**power
    distance = (start / factor) ** (1 / power)
    return shade / (2 * start), f" fade_power {power} fade_distance {text(distance)}"


def directional_light(light: DirectionalLight, scene: Scene, lost: Losses) -> str:
    middle, reach = extent(scene)
    towards = plain(light.direction)
    source = middle + towards / np.linalg.norm(towards) * reach * FAR
    return f"light_source {{ {place(source)} {colour(rgb(light.colour))} parallel point_at {place(middle)} }}"


LIGHTS: dict[type, Callable[..., str]] = {
    PointLight: point_light,
    DirectionalLight: directional_light,
    SpotLight: spot_light,
    WarnLight: spot_light,
    RectangleLight: rectangle_light,
    SphereLight: sphere_light,
}


def constant(background: ConstantBackground) -> str:
    return f"background {{ {colour(rgb(background.colour))} }}"


def gradient(background: GradientBackground) -> str:
    ends = f"[0 {colour(rgb(background.bottom))}] [1 {colour(rgb(background.top))}]"
    return f"sky_sphere {{ pigment {{ gradient y color_map {{ {ends} }} scale 2 translate -1 }} }}"


def sky_map(file: str, turned_deg: float) -> str:
    """An equirectangular map, turned from ahead to the right."""
    return (
        f'sky_sphere {{ pigment {{ image_map {{ exr "{file}" map_type 1 interpolate 2 }} '
        f"scale <-1,1,1> rotate y*{text(TURN + turned_deg)} }} }}"
    )


TURN = -90.0
"""Mirrored, as its columns run to the left there, its middle column looks to the right."""

BACKGROUNDS: dict[type, Callable[..., str]] = {ConstantBackground: constant, GradientBackground: gradient}


def perspective(view: Camera) -> str:
    """A ray is direction + u right + v up, u and v from -1/2 to 1/2."""
    window, where = frustum(view), place(plain(view.look_from))
    across, down = window.size
    if window.is_centred:
        return (
            f"camera {{ perspective location {where} direction <0,0,{text(1 / down)}> up <0,1,0> "
            f"right <{text(across / down)},0,0> {_look(view, np.zeros(3))} }}"
        )
    # look_at would make the direction square to the picture again.
    right, up, back = axes_of(view)
    skew = window.middle @ (right, up) - back
    return (
        f"camera {{ perspective location {where} direction {place(skew)} up {place(up * down)} "
        f"right {place(right * across)} }}"
    )


def orthographic(view: OrthographicCamera) -> str:
    """The first word makes `right` and `up` the size of what is seen, whatever look_at is."""
    (across, down), shift = box(view).size, aside(view)
    return (
        f"camera {{ orthographic location {place(plain(view.look_from) + shift)} up <0,{text(down)},0> "
        f"right <{text(across)},0,0> {_look(view, shift)} }}"
    )


def _look(view: Camera | OrthographicCamera, shift: np.ndarray) -> str:
    return f"sky {place(plain(view.up))} look_at {place(plain(view.look_at) + shift)}"


CAMERAS: dict[type, Callable[..., str]] = {Camera: perspective, OrthographicCamera: orthographic}
