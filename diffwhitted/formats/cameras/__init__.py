"""Cameras that other programs have measured: COLMAP's models as text, and transforms.json."""

from ._read import read_cameras

__all__ = ["read_cameras"]
