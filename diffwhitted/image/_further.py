"""Further channels beside the picture in a file: depth, normals, numbers of objects."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from ._faults import ImageError


def with_layers(
    path: Path, spec: oiio.ImageSpec, stored: np.ndarray, layers: Mapping[str, np.ndarray]
) -> tuple[oiio.ImageSpec, np.ndarray]:
    """What the file says of itself, and what it stores, (height, width, channels), with these channels after those of
    the picture.

    Raises `ImageError` for another format than OpenEXR, another shape, and a name that is the picture's or repeated.
    """
    if path.suffix.lower() != ".exr":
        raise ImageError(f"{path}: {path.suffix} holds no layers; leave them out, or write .exr.")
    own, size = list(spec.channelnames), stored.shape[:2]
    for name, channel in layers.items():
        if np.shape(channel) != size:
            raise ImageError(
                f"{path}: layer {name!r} has shape {np.shape(channel)}; allowed is {size}, that of the pixels."
            )
        if "." not in name.strip("."):
            raise ImageError(f"{path}: layer {name!r}; allowed is LAYER.CHANNEL, such as 'depth.Z'.")
    spec.nchannels = len(own) + len(layers)
    spec.channelformats = tuple([spec.format] * len(own) + [oiio.TypeDesc("float")] * len(layers))
    spec.channelnames = (*own, *layers)
    further = [np.asarray(channel, np.float32)[..., None] for channel in layers.values()]
    return spec, np.ascontiguousarray(np.concatenate([stored, *further], axis=2))
