"""COLMAP's models as text (colmap.github.io, Output Format): cameras.txt and images.txt.

A camera of cameras.txt is a line CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]; a picture of images.txt is a line IMAGE_ID QW
QX QY QZ TX TY TZ CAMERA_ID NAME, from world to camera, and a line of the points in it, which may be empty. The camera
looks along its z with y down; (0.5, 0.5) is the middle of the top left pixel.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..._errors import SceneError
from ...records import nearest_name
from ...scene import Camera
from ._names import names_of

MODELS: dict[str, str] = {
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
    "OPENCV": "fx fy cx cy k1 k2 p1 p2",
}
"""The numbers of each camera model that is known."""


def colmap_cameras(cameras: Path, images: Path) -> dict[str, Camera]:
    """The cameras of the two files, one a picture. Raises `SceneError`."""
    lenses = dict(_lens(place, line.split()) for place, line in _lines(cameras))
    pictures = list(_pictures(images))
    if not pictures:
        raise SceneError(f"{images}: there is no picture in it, and so no camera")
    made = []
    for place, words in pictures:
        if words[8] not in lenses:
            known = ", ".join(lenses) or "none"
            raise SceneError(f"{place}: camera {words[8]} is not in {cameras.name}; there is {known}")
        pose = _pose(place, _numbers(place, words[1:8]))
        made.append(
            Camera.from_pose(
                pose, "opencv", place=f"{place}: {words[9]!r}, camera {words[8]} of {cameras.name}", **lenses[words[8]]
            )
        )
    return dict(zip(names_of([words[9] for _, words in pictures], str(images)), made, strict=True))


def _lens(place: str, words: list[str]) -> tuple[str, dict[str, Any]]:
    """The number of a camera and what it is apart from its place."""
    if len(words) < 4:
        raise SceneError(
            f"{place}: {len(words)} words; allowed is CAMERA_ID MODEL WIDTH HEIGHT and the model's numbers"
        )
    model = words[1]
    if model not in MODELS:
        known = ", ".join(MODELS)
        raise SceneError(
            f"{place}: the camera model {model} is not known; allowed is {known}.{nearest_name(model, MODELS)} "
            "Undistort the pictures with: colmap image_undistorter"
        )
    names = MODELS[model].split()
    if len(words) != 4 + len(names):
        raise SceneError(f"{place}: {len(words) - 4} numbers; allowed for {model} is {len(names)}: {MODELS[model]}")
    width, height, *numbers = _numbers(place, words[2:])
    stated = dict(zip(names, numbers, strict=True))
    distortion = tuple(stated.get(name, 0.0) for name in ("k1", "k2", "p1", "p2"))
    return words[0], {
        "width": int(width) if width.is_integer() else width,
        "height": int(height) if height.is_integer() else height,
        "focal": (stated.get("fx", stated.get("f")), stated.get("fy", stated.get("f"))),
        "principal_point": (stated["cx"], stated["cy"]),
        "distortion": distortion if any(distortion) else None,
    }


def _pictures(path: Path) -> Iterator[tuple[str, list[str]]]:
    """The lines of pictures, the name as the last word; lines of points are skipped."""
    points_follow = False
    for place, line in _lines(path, empty=True):
        words = line.split(maxsplit=9)
        if points_follow and _is_points(line):
            points_follow = False
        elif words:
            if len(words) < 10:
                raise SceneError(
                    f"{place}: {len(words)} words; allowed is IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, and below "
                    "it a line of points, which may be empty"
                )
            points_follow = True
            yield place, words


def _is_points(line: str) -> bool:
    """Is it a line of X Y POINT3D_ID again and again, or an empty one?"""
    words = line.split()
    try:
        return len(words) % 3 == 0 and all(np.isfinite(float(word)) for word in words[:3])
    except ValueError:
        return False


def _pose(place: str, numbers: list[float]) -> np.ndarray:
    """Camera to world, of a quaternion and a shift from world to camera: x_world = R^T (x_camera - t)."""
    quaternion, shift = np.asarray(numbers[:4]), np.asarray(numbers[4:])
    size = np.linalg.norm(quaternion)
    if not 0 < size < np.inf:
        raise SceneError(f"{place}: QW QX QY QZ = {quaternion.tolist()} is no turn; allowed is any but zero")
    w, *v = quaternion / size
    x, y, z = v
    skew = np.asarray([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation = np.eye(3) + 2 * w * skew + 2 * skew @ skew
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation.T, -rotation.T @ shift
    return pose


def _lines(path: Path, empty: bool = False) -> Iterator[tuple[str, str]]:
    """Lines that are no comments, and what messages call them."""
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if not line.startswith("#") and (empty or line.strip()):
                yield f"{path}: line {number}", line.strip()


def _numbers(place: str, words: list[str]) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError:
        raise SceneError(f"{place}: {' '.join(words)!r} are not all numbers") from None
