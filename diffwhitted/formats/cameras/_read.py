"""Cameras of another program, by what stands under a path."""

import os
from pathlib import Path

from ..._errors import SceneError
from ..._files import not_a_file
from ...records import nearest_name
from ...scene import Camera
from ._colmap import colmap_cameras
from ._transforms import transforms_cameras

COLMAP = ("cameras.txt", "images.txt")
TRANSFORMS = "transforms.json"
ALLOWED = f"allowed is a folder with {' and '.join(COLMAP)} of COLMAP, or a {TRANSFORMS} of NeRF programs"


def read_cameras(path: str | os.PathLike) -> dict[str, Camera]:
    """The cameras that another program has measured, by the names of their pictures.

    `path`: a folder with a model of COLMAP as text (`cameras.txt`, `images.txt`), or a `transforms.json` of NeRF,
    instant-ngp or nerfstudio, or the folder that it lies in. Of COLMAP's camera models SIMPLE_PINHOLE, PINHOLE,
    SIMPLE_RADIAL, RADIAL and OPENCV are known. Places are in the units of the file, taken for metres.

    A camera is called as its picture is without folder and suffix, dots as `_`; where two pictures share that name,
    by their folders too (`left_0001`). Raises `SceneError` for what cannot be read, and for camera models, keys or
    poses that are not known or not valid, naming the file and the picture.
    """
    path = Path(path)
    if kind := not_a_file(path):
        raise SceneError(f"{path}: this is {kind}; {ALLOWED}")
    try:
        if path.is_dir():
            return _of_folder(path)
        if path.name in COLMAP:
            return _of_folder(path.parent)
        if path.suffix.lower() == ".json":
            return transforms_cameras(path)
        if path.is_file():
            raise SceneError(f"{path}: no cameras are known in a file of this kind; {ALLOWED}")
    except UnicodeDecodeError:
        raise SceneError(f"{path}: this is not UTF-8 text; {ALLOWED}") from None
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    beside = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
    raise SceneError(f"{path}: there is no such file or folder; {ALLOWED}.{nearest_name(path.name, beside)}")


def _of_folder(folder: Path) -> dict[str, Camera]:
    there = [name for name in (*COLMAP, TRANSFORMS) if (folder / name).exists()]
    if set(COLMAP) <= set(there):
        return colmap_cameras(*(folder / name for name in COLMAP))
    if TRANSFORMS in there:
        return transforms_cameras(folder / TRANSFORMS)
    if (folder / "cameras.bin").exists():
        raise SceneError(
            f"{folder}: this model of COLMAP is binary; allowed is text. Convert it with: colmap model_converter "
            f"--input_path {folder} --output_path {folder} --output_type TXT"
        )
    inside = [f"{below.name}/" for below in sorted(folder.iterdir()) if (below / COLMAP[0]).exists()]
    advice = f" Did you mean {folder / inside[0]}?" if inside else ""
    missing = f"{', '.join(there)} is there alone" if there else "there are no cameras in this folder"
    raise SceneError(f"{folder}: {missing}; {ALLOWED}.{advice}")
