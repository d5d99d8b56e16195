"""The one list of cameras. A new camera is a file in this folder and its name here; the first is the default."""

from ...records import Registry
from ._camera import AbstractCamera
from ._orthographic import OrthographicCamera
from ._perspective import Camera

CAMERAS: Registry[AbstractCamera] = Registry("camera", AbstractCamera, Camera, OrthographicCamera)
