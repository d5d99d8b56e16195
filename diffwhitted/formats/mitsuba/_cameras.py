"""Cameras as sensors of Mitsuba."""

from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...scene import AbstractCamera, Camera, OrthographicCamera, Scene
from .._losses import Losses, Thing
from .._numbers import listed, plain, text
from .._views import aside, box, frustum, views_of
from ._words import number, whole, word

SAMPLES = 64
"""Paths a pixel."""
SQUARE = 1e-6
"""Two focal lengths that differ by less, as a part of them, are one."""


def add_cameras(root: Element, scene: Scene, lost: Losses) -> None:
    """A sensor for each; the first is what Mitsuba renders."""
    for name, view in views_of(scene, (Camera, OrthographicCamera), lost).items():
        if isinstance(view, OrthographicCamera):
            sensor = _orthographic(root, view)
        elif isinstance(view, Camera):
            sensor = _perspective(root, view, ("camera", name), lost)
        film = SubElement(sensor, "film", type="hdrfilm")
        whole(film, "width", view.width)
        whole(film, "height", view.height)
        word(film, "pixel_format", "rgb")
        SubElement(film, "rfilter", type="box")
        whole(SubElement(sensor, "sampler", type="independent"), "sample_count", SAMPLES)


def _perspective(root: Element, view: Camera, what: Thing, lost: Losses) -> Element:
    window = frustum(view)
    sensor = SubElement(root, "sensor", type="perspective")
    number(sensor, "fov", 2 * float(np.degrees(np.arctan(window.size[1] / 2))))
    word(sensor, "fov_axis", "y")
    if not window.is_centred:
        # Say where the middle of the picture lies from look_at: to the right and down, in sizes of the picture.
        for axis, offset in zip("xy", window.middle / window.size * (1, -1), strict=True):
            number(sensor, f"principal_point_offset_{axis}", offset)
    if view.focal is not None and np.ptp(plain(view.focal)) > SQUARE * plain(view.focal).min():
        lost.say("focal of {}: that down the picture is also that across, as pixels are square", what)
    _look(SubElement(sensor, "transform", name="to_world"), view, np.zeros(3))
    return sensor


def _orthographic(root: Element, view: OrthographicCamera) -> Element:
    """Without a scale the picture is 2 wide."""
    sensor = SubElement(root, "sensor", type="orthographic")
    transform = SubElement(sensor, "transform", name="to_world")
    half = text(box(view).size[0] / 2)
    SubElement(transform, "scale", x=half, y=half)
    _look(transform, view, aside(view))
    return sensor


def _look(transform: Element, view: AbstractCamera, shift: np.ndarray) -> None:
    places = {"origin": plain(view.look_from) + shift, "target": plain(view.look_at) + shift, "up": plain(view.up)}
    SubElement(transform, "lookat", {key: listed(place, ", ") for key, place in places.items()})
