"""Cameras, a kind a file."""

from ._camera import PRINCIPAL_POINT, VIEW, AbstractCamera
from ._kinds import CAMERAS
from ._lens import BLUR_SAMPLES, MOST_BLUR_SAMPLES
from ._orthographic import OrthographicCamera
from ._perspective import Camera

__all__ = [
    "BLUR_SAMPLES", "CAMERAS", "MOST_BLUR_SAMPLES", "PRINCIPAL_POINT", "VIEW", "AbstractCamera", "Camera",
    "OrthographicCamera",
]  # fmt: skip
