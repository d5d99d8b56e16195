"""transforms.json, as NeRF's data sets, instant-ngp and nerfstudio have it (docs.nerf.studio, Data conventions).

Each of the `frames` has a `file_path` and a `transform_matrix`, camera to world in OpenGL's axes. What the lens is like
stands beside `frames`, or in a frame: camera_angle_x (radians) or fl_x, fl_y; cx, cy; w, h; k1, k2, p1, p2.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..._errors import SceneError
from ...scene import Camera
from ._names import names_of

MODELS = ("PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "SIMPLE_RADIAL", "RADIAL")
"""Values of camera_model whose numbers are those above."""
UNKNOWN = ("k3", "k4", "k5", "k6")
"""Numbers of other models, which must be 0."""
SUFFIXES = ("", ".png", ".jpg", ".jpeg", ".exr")
"""Of a picture whose file_path may lack one."""


def transforms_cameras(path: Path) -> dict[str, Camera]:
    """The cameras of a file, one a frame. Raises `SceneError`."""
    document = _document(path)
    frames = document.get("frames")
    if not isinstance(frames, list) or not frames or not all(isinstance(frame, dict) for frame in frames):
        raise SceneError(
            f"{path}: frames is missing or empty; allowed is a list with a transform_matrix for each picture"
        )
    pictures = [str(frame.get("file_path", f"frame_{number}")) for number, frame in enumerate(frames, 1)]
    made, size = [], None
    for picture, frame in zip(pictures, frames, strict=True):
        stated = _Stated(f"{path}: frame {picture!r}", {**document, **frame})
        if "w" not in stated.keys or "h" not in stated.keys:
            size = size or _size_of(path.parent, picture, stated.place)
        made.append(_camera(stated, size))
    return dict(zip(names_of(pictures, str(path)), made, strict=True))


class _Stated:
    """The keys of a frame, with those of the whole file where it has none of its own."""

    def __init__(self, place: str, keys: Mapping[str, Any]):
        self.place, self.keys = place, keys

    def number(self, key: str, default: float | None = None) -> float | None:
        value = self.keys.get(key, default)
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float)) or abs(value) > 1e300):
            raise SceneError(f"{self.place}: {key} = {value!r}; allowed is a number")
        return None if value is None else float(value)


def _camera(stated: _Stated, size: tuple[int, int] | None) -> Camera:
    place, keys = stated.place, stated.keys
    model = keys.get("camera_model", "OPENCV")
    if model not in MODELS or keys.get("is_fisheye"):
        name = model if model not in MODELS else "a fisheye"
        raise SceneError(f"{place}: the camera model {name} is not known; allowed is {', '.join(MODELS)}")
    for key in UNKNOWN:
        if stated.number(key, 0.0):
            raise SceneError(f"{place}: {key} = {keys[key]!r}; allowed is 0: distortions are those of k1, k2, p1, p2")
    width, height = (stated.number(key, default) for key, default in zip("wh", size or (None, None), strict=True))
    if width is None or height is None or width % 1 or height % 1:
        raise SceneError(f"{place}: w = {width}, h = {height}; allowed are whole numbers of pixels")
    distortion = tuple(stated.number(key, 0.0) for key in ("k1", "k2", "p1", "p2"))
    middle = stated.number("cx"), stated.number("cy")
    return Camera.from_pose(
        _pose(place, keys.get("transform_matrix")),
        "opengl",
        width=int(width),
        height=int(height),
        focal=_focal(stated, width, height),
        principal_point=None
        if middle == (None, None)
        else tuple(side / 2 if at is None else at for at, side in zip(middle, (width, height), strict=True)),
        distortion=distortion if any(distortion) else None,
        place=place,
    )


def _focal(stated: _Stated, width: float, height: float) -> tuple[float, float]:
    """fx and fy in pixels; one of the two serves for both."""
    found: list[float] = []
    for axis, side in (("x", width), ("y", height)):
        length, angle = stated.number(f"fl_{axis}"), stated.number(f"camera_angle_{axis}")
        if length is None and angle is not None:
            if not 0 < angle < math.pi:
                raise SceneError(
                    f"{stated.place}: camera_angle_{axis} = {angle}; allowed is between 0 and pi (radians)"
                )
            length = side / 2 / math.tan(angle / 2)
        if length is not None:
            found.append(length)
    if not found:
        raise SceneError(
            f"{stated.place}: fl_x is missing, and so is camera_angle_x; one of them says how wide it sees"
        )
    return found[0], found[-1]


def _pose(place: str, matrix) -> np.ndarray:
    if matrix is None:
        raise SceneError(f"{place}: transform_matrix is missing; allowed is a matrix of 4 x 4, camera to world")
    try:
        pose = np.asarray(matrix, np.float64)
    except (TypeError, ValueError, OverflowError):
        pose = np.zeros(0)
    if pose.shape not in ((4, 4), (3, 4)):
        raise SceneError(f"{place}: transform_matrix is no matrix of 4 x 4 numbers, camera to world")
    return pose if pose.shape == (4, 4) else np.concatenate([pose, [[0, 0, 0, 1]]])


def _size_of(folder: Path, picture: str, place: str) -> tuple[int, int]:
    """Width and height of a picture, which the file leaves out."""
    from ...image import ImageError, read_image  # slow to import, and most files state the size

    for suffix in SUFFIXES:
        path = folder / f"{picture}{suffix}"
        if path.is_file():
            try:
                return read_image(path).pixels.shape[1::-1]
            except ImageError as error:
                raise SceneError(f"{place}: w and h are missing, and the picture cannot tell: {error}") from None
    raise SceneError(f"{place}: w and h are missing, and so is the picture {folder / picture}; write both, in pixels")


def _document(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    except json.JSONDecodeError as error:
        raise SceneError(f"{path}: line {error.lineno}, column {error.colno}: broken JSON: {error.msg}") from None
    except RecursionError:
        raise SceneError(f"{path}: brackets are nested too deeply") from None
    if not isinstance(document, dict):
        raise SceneError(f"{path}: allowed is one object {{...}} with frames")
    return document
