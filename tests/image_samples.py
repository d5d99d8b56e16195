"""Pictures and files for the tests of the image room."""

import numpy as np
import OpenImageIO as oiio
import pytest

from diffwhitted._errors import printable
from diffwhitted.image import ImageError

LINEAR = ["a.exr", "a.hdr", "a.tif"]
EVERY = [*LINEAR, "a.png", "a.jpg"]


def scene_light(height=6, width=9):
    """Positive light from 0.01 to 20, no two pixels alike."""
    levels = np.geomspace(0.01, 20, height * width * 3, dtype=np.float32)
    return np.random.default_rng(3).permutation(levels).reshape(height, width, 3)


def store(path, values, *, number=None, names=None, window=None, **attributes):
    """Writes raw numbers with OpenImageIO alone; window is x, y, then the full x, y, width, height."""
    values = np.ascontiguousarray(values)
    number = number or {"float32": "float"}.get(values.dtype.name, values.dtype.name)
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], number)
    if names:
        spec.channelnames = names
    if window:
        spec.x, spec.y, spec.full_x, spec.full_y, spec.full_width, spec.full_height = window
    for name, value in attributes.items():
        if isinstance(value, tuple):
            spec.attribute(name, oiio.TypeDesc(f"float[{len(value)}]"), value)
        else:
            spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(values) and output.close(), output.geterror()
    output.geterror()
    return path


def refusal(function, *arguments, **options):
    """The message of the ImageError that a call raises."""
    with pytest.raises(ImageError) as caught:
        function(*arguments, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(printable(f"{arguments[0]}: "))
    return message
