"""What cameras see, by the edges of their pictures, for programs that have other words for it."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ..scene import AbstractCamera, Camera, OrthographicCamera, Scene
from ._losses import Losses
from ._numbers import plain

SAID = ("look_from", "look_at", "up", "vfov_deg", "view_height", "focal", "principal_point", "width", "height", "crop")
"""The keys that axes and window say together."""
CENTRED = 1e-9
"""So far from straight ahead, in sizes of the window, is rounding."""


@dataclass(frozen=True)
class Window:
    """What a picture shows of a plane across the view: to the right and up of what is straight ahead."""

    middle: np.ndarray
    size: np.ndarray

    @property
    def is_centred(self) -> bool:
        return bool((abs(self.middle) <= CENTRED * self.size).all())


def frustum(view: Camera, *, whole: bool = False) -> Window:
    """At 1 m ahead; of the full picture of a crop if `whole`."""
    if view.focal is not None:
        return _window(view, plain(view.focal), whole)
    return _window(view, view.full[1] / (2 * np.tan(np.radians(plain(view.vfov_deg)) / 2)) * np.ones(2), whole)


def box(view: OrthographicCamera) -> Window:
    """In the plane of the camera, metres."""
    return _window(view, view.full[1] / plain(view.view_height) * np.ones(2), whole=False)


def _window(view: AbstractCamera, pixels: np.ndarray, whole: bool) -> Window:
    """`pixels` (2,): how many are a metre, across and down."""
    full = np.asarray(view.full, float)
    corner, sides = (
        (np.zeros(2), full) if whole or view.crop is None else np.reshape(np.asarray(view.crop, float), (2, 2))
    )
    ahead = full / 2 if view.principal_point is None else plain(view.principal_point)
    return Window((corner + sides / 2 - ahead) * (1, -1) / pixels, sides / pixels)


def axes_of(view: AbstractCamera) -> np.ndarray:
    """Unit vectors to the right, up and back, the rows of a (3, 3)."""
    ahead = plain(view.look_at) - plain(view.look_from)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, plain(view.up))
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, ahead), -ahead])


def aside(view: OrthographicCamera) -> np.ndarray:
    """From where it stands to the middle of its picture, (3,), metres."""
    return box(view).middle @ axes_of(view)[:2]


def views_of(scene: Scene, known: Collection[type], lost: Losses) -> dict[str, AbstractCamera]:
    """The cameras of the known kinds; first, for a program that knows one, "main", or the first. All else is told."""
    found = {}
    for name in sorted(scene.cameras, key=lambda name: name != "main"):
        view, what = scene.cameras[name], ("camera", name)
        if type(view) not in known:
            lost.say(f"left out: {{}} ({view.written_type()})", what)
            continue
        straight = isinstance(view, Camera) and view.distortion is not None and not np.any(view.distortion)
        lost.unknown(view, (*SAID, "distortion") if straight else SAID, what)
        found[name] = view
    return found
