"""Cameras that blur, looked through by another number of trees."""

from ..records import changed
from ..scene import AbstractCamera

CONVERGED_BLUR = 16
"""Places in the lens, and times, of each tree of a camera that blurs, in a reference, whose trees have places of their
own."""


def blurs(camera: AbstractCamera) -> bool:
    """Has the camera a lens, or is its shutter open for a while?"""
    return any(value is not None and float(value) > 0 for value in (camera.aperture, camera.shutter))


def with_blur_samples(camera: AbstractCamera, samples: int | None) -> AbstractCamera:
    """The camera with so many trees a pixel for what it blurs; None leaves it as it is."""
    return changed(camera, blur_samples=samples) if samples is not None and blurs(camera) else camera
