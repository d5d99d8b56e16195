"""What a glTF or GLB file holds: its JSON, its bytes, and the arrays in them, each checked against what is there."""

import base64
import binascii
import json
import struct
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ..._errors import SceneError

MAGIC, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
LARGEST_PART = 2**31
"""Bytes of one file that the first one names."""


class Content:
    """The JSON of a file, as `json`, and its arrays. Raises `SceneError` that begins with the name of the file."""

    def __init__(self, data: bytes, source: str):
        self.source = source
        text, self._inside = _chunks(data, source)
        try:
            self.json: dict[str, Any] = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise SceneError(f"{source}: broken JSON: {error}") from None
        if not isinstance(self.json, dict) or not isinstance(self.json.get("asset"), dict):
            raise SceneError(f"{source}: this is no glTF: it has no asset; allowed is glTF 2.0")
        version = str(self.json["asset"].get("version", ""))
        if not version.startswith("2"):
            raise SceneError(f"{source}: glTF version {version!r}; allowed is 2.0. Export it anew")
        needed = [name for name in self.json.get("extensionsRequired", []) if name not in READ]
        if needed:
            raise SceneError(f"{source}: needs the extension {needed[0]}, which is not read; export it without")

    def listed(self, key: str) -> list[dict[str, Any]]:
        found = self.json.get(key, [])
        if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
            raise SceneError(f"{self.source}: {key} is not a list of objects")
        return found

    def one(self, key: str, number, where: str) -> dict[str, Any]:
        """Entry `number` of a list; `where` is what names it."""
        entries = self.listed(key)
        if not isinstance(number, int) or not 0 <= number < len(entries):
            raise SceneError(f"{self.source}: {where} names {key}[{number!r}], and there are {len(entries)}")
        return entries[number]

    def array(self, number, where: str) -> np.ndarray:
        """The numbers of an accessor, (n,) or (n, width); whole ones that stand for parts of 1 as such."""
        accessor = self.one("accessors", number, where)
        if "sparse" in accessor:
            raise SceneError(f"{self.source}: {where}: sparse accessors are not read; export it without")
        kind, width = COMPONENTS.get(accessor.get("componentType", 0)), WIDTHS.get(accessor.get("type", ""))
        count, start = accessor.get("count"), accessor.get("byteOffset", 0)
        if kind is None or width is None or not isinstance(count, int) or count < 0 or not isinstance(start, int):
            raise SceneError(f"{self.source}: {where}: accessors[{number}] is not described as glTF 2.0 says")
        view = self.one("bufferViews", accessor.get("bufferView"), where)
        data = self._bytes(view.get("buffer"), where)
        size = np.dtype(kind).itemsize * width
        step, start = view.get("byteStride", size), start + view.get("byteOffset", 0)
        end = start + (count - 1) * step + size if count else start
        if start < 0 or step < size or end > len(data):
            raise SceneError(
                f"{self.source}: {where}: accessors[{number}] promises {count:,} entries up to byte {end:,}, and its "
                f"buffer has {len(data):,}; the file was cut short"
            )
        found = np.ndarray((count, width), kind, data, start, (step, np.dtype(kind).itemsize))
        if accessor.get("normalized"):
            found = np.maximum(found / np.iinfo(kind).max, -1.0)
        return found[:, 0] if width == 1 else found

    def bytes_of_view(self, number, where: str) -> bytes:
        view = self.one("bufferViews", number, where)
        start, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        return self._bytes(view.get("buffer"), where)[start : start + length]

    def _bytes(self, number, where: str) -> bytes:
        buffer = self.one("buffers", number, where)
        if number not in self._read:
            uri = buffer.get("uri")
            self._read[number] = self._inside if uri is None else self.file(uri, where)
        return self._read[number]

    @cached_property
    def _read(self) -> dict[int, bytes]:
        return {}

    def file(self, uri: str, where: str) -> bytes:
        """What a data URI holds, or a file beside this one."""
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            try:
                return base64.b64decode(body, validate=True) if head.endswith(";base64") else unquote(body).encode()
            except (binascii.Error, ValueError) as error:
                raise SceneError(f"{self.source}: {where}: a data URI is broken: {error}") from None
        path = self.path(uri, where)
        if path.stat().st_size > LARGEST_PART:
            raise SceneError(f"{self.source}: {where}: {uri!r} has more than {LARGEST_PART >> 30} GiB")
        return path.read_bytes()

    def path(self, uri: str, where: str) -> Path:
        """A file beside this one. Raises `SceneError` for one that is elsewhere or not there."""
        beside = Path(unquote(uri))
        if beside.is_absolute() or ".." in beside.parts or ":" in uri:
            raise SceneError(f"{self.source}: {where}: {uri!r} is not beside the file; put it there")
        path = Path(self.source).parent / beside
        if not path.is_file():
            raise SceneError(f"{self.source}: {where}: there is no file {uri!r} beside it")
        return path


READ = {
    "KHR_lights_punctual", "KHR_materials_ior", "KHR_materials_specular", "KHR_materials_transmission",
    "KHR_materials_volume",
}  # fmt: skip
"""The extensions that are read."""


def _chunks(data: bytes, source: str) -> tuple[bytes, bytes]:
    """The JSON and the bytes of a file."""
    if len(data) < 12 or struct.unpack("<I", data[:4])[0] != MAGIC:
        return data, b""
    found, at = {}, 12
    while at + 8 <= len(data):
        length, kind = struct.unpack("<II", data[at : at + 8])
        if at + 8 + length > len(data):
            raise SceneError(f"{source}: a chunk promises {length:,} bytes more than there are; it was cut short")
        found.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if JSON_CHUNK not in found:
        raise SceneError(f"{source}: this GLB holds no JSON; allowed is glTF 2.0")
    return found[JSON_CHUNK], found.get(BINARY_CHUNK, b"")
