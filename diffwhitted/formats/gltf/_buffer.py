"""The numbers of a glTF file: one buffer, in the file itself, with a view and an accessor for each array."""

import base64
import struct
import zlib
from typing import Any

import numpy as np

ARRAY, ELEMENTS = 34962, 34963
FLOAT, UNSIGNED = 5126, 5125
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


class Buffer:
    """Bytes that grow by arrays, each begun at a multiple of four."""

    def __init__(self):
        self._bytes = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def vectors(self, values: np.ndarray, with_bounds: bool = False) -> int:
        """The number of the accessor of vectors (n, 2) or (n, 3), float32; `with_bounds` as positions need them."""
        values = np.asarray(values, np.float32)
        bounds = {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()} if with_bounds else {}
        return self._accessor(values.tobytes(), ARRAY, FLOAT, len(values), KINDS[values.shape[1]], bounds)

    def numbers(self, values: np.ndarray) -> int:
        """The number of the accessor of the corners of triangles."""
        values = np.asarray(values, np.uint32).ravel()
        return self._accessor(values.tobytes(), ELEMENTS, UNSIGNED, len(values), KINDS[1], {})

    def _accessor(self, data: bytes, target: int, component: int, count: int, kind: str, bounds: dict) -> int:
        self.views.append({"buffer": 0, "byteOffset": len(self._bytes), "byteLength": len(data), "target": target})
        self._bytes += data + bytes(-len(data) % 4)
        view = len(self.views) - 1
        self.accessors.append({"bufferView": view, "componentType": component, "count": count, "type": kind, **bounds})
        return len(self.accessors) - 1

    def written(self) -> dict[str, Any]:
        return {"byteLength": len(self._bytes), "uri": _uri("application/octet-stream", bytes(self._bytes))}


def picture(pixels: np.ndarray) -> str:
    """A data URI of a PNG of pixels (height, width, 3), whole numbers from 0 to 255 in sRGB."""
    height, width, _ = pixels.shape
    lines = b"".join(b"\0" + line.astype(np.uint8).tobytes() for line in pixels)
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(lines)),
        (b"IEND", b""),
    )
    body = b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
    return _uri("image/png", b"\x89PNG\r\n\x1a\n" + body)


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
