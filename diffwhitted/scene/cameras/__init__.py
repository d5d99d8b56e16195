"""Cameras, a kind a file."""

from ._camera import VIEW, AbstractCamera
from ._kinds import CAMERAS
from ._orthographic import OrthographicCamera
from ._perspective import Camera

__all__ = ["CAMERAS", "VIEW", "AbstractCamera", "Camera", "OrthographicCamera"]
