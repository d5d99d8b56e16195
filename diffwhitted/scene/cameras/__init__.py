"""Cameras, a kind a file."""

from ._camera import PRINCIPAL_POINT, VIEW, AbstractCamera
from ._kinds import CAMERAS
from ._orthographic import OrthographicCamera
from ._perspective import Camera

__all__ = ["CAMERAS", "PRINCIPAL_POINT", "VIEW", "AbstractCamera", "Camera", "OrthographicCamera"]
