"""Pictures and files for the tests of the image room."""

import struct
import zlib

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
        if isinstance(value, np.ndarray):
            spec.attribute(name, oiio.TypeDesc(f"uint8[{len(value)}]"), value)
        elif isinstance(value, tuple):
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


def chunk(kind, data):
    """A chunk of a PNG."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def store_png(path, codes, *chunks, bits=None):
    """Writes whole numbers as a PNG with chunks before the pixels, each a pair of kind and data."""
    codes = np.ascontiguousarray(codes)
    height, width, channels = codes.shape
    bits = bits or 8 * codes.dtype.itemsize
    rows = [row.astype(">u2" if bits == 16 else "u1").tobytes() for row in codes]
    if bits < 8:
        rows = [np.packbits([[c >> b & 1 for b in range(bits)[::-1]] for c in row.ravel()]).tobytes() for row in codes]
    header = struct.pack(">IIBBBBB", width, height, bits, {1: 0, 3: 2}[channels], 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    parts = [(b"IHDR", header), *chunks, (b"IDAT", pixels), (b"IEND", b"")]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts))
    return path


def gama(value):
    return b"gAMA", struct.pack(">I", value)


def store_parts(path, *parts):
    """Writes an OpenEXR file of several parts, each a name, names of channels, and values (height, width, channels)."""
    specs = []
    for name, channels, values in parts:
        spec = oiio.ImageSpec(values.shape[1], values.shape[0], len(channels), "float")
        spec.channelnames = channels
        spec.attribute("oiio:subimagename", name)
        specs.append(spec)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), tuple(specs))
    for index, (_, _, values) in enumerate(parts):
        assert index == 0 or output.open(str(path), specs[index], "AppendSubimage")
        assert output.write_image(np.ascontiguousarray(values, np.float32))
    assert output.close(), output.geterror()
    return path


def profile(columns, curves, space=b"RGB ", connection=b"XYZ "):
    """An ICC profile: the X, Y, Z of red, green and blue, and the bytes of a curve element for each channel."""
    fixed = [struct.pack(">4s4x3i", b"XYZ ", *(round(number * 65536) for number in column)) for column in columns]
    elements = dict(zip((b"rXYZ", b"gXYZ", b"bXYZ"), fixed, strict=True))
    elements |= dict(zip((b"rTRC", b"gTRC", b"bTRC") if len(curves) == 3 else (b"kTRC",), curves, strict=True))
    table, body, start = b"", b"", 132 + 12 * len(elements)
    for name, element in elements.items():
        element += bytes(-len(element) % 4)
        table += struct.pack(">4sII", name, start + len(body), len(element))
        body += element
    size = start + len(body)
    head = struct.pack(">I4xI4s4s4s12x4s", size, 0x04000000, b"mntr", space, connection, b"acsp").ljust(128, b"\0")
    return head + struct.pack(">I", len(elements)) + table + body


def power_curve(exponent):
    return struct.pack(">4s4xIH", b"curv", 1, round(exponent * 256))


def table_curve(values):
    return struct.pack(f">4s4xI{len(values)}H", b"curv", len(values), *(round(value * 65535) for value in values))


def iccp(data):
    return b"iCCP", b"a profile\0\0" + zlib.compress(data)
