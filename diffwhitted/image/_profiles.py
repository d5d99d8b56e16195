"""ICC profiles of a matrix and curves: what cameras, screens and editors put into pictures (ICC.1:2022).

A profile of tables (for printers, some scanners) is not read; so is one of another kind than RGB or grey.
"""

import struct
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ._encodings import decode_signal, gamma
from ._gamut import from_xyz_columns

Curve = Callable[[np.ndarray], np.ndarray]

_KNOWN = ("linear", "srgb", "rec709")
_SAME_CURVE = 2e-4
_SAME_MATRIX = 3e-3
_MOST_TAGS = 200


class Profile(NamedTuple):
    """Light of a signal by a profile: a curve for each channel (or one for all), then a matrix to Rec.709.

    encoding: the name of the curve where all channels have one that has a name; None else.
    """

    curves: tuple[Curve, ...]
    matrix: Float[np.ndarray, "3 3"] | None
    encoding: str | None


def read_profile(data: bytes) -> Profile | None:
    """What the bytes of a profile say; None for a profile that is broken or of another kind."""
    try:
        tags = _tags(data)
        space = data[16:20]
        if space == b"GRAY" and b"kTRC" in tags:
            curves, matrix = (_curve(tags[b"kTRC"]),), None
        elif space == b"RGB " and data[20:24] == b"XYZ ":
            curves = tuple(_curve(tags[name]) for name in (b"rTRC", b"gTRC", b"bTRC"))
            matrix = from_xyz_columns(np.stack([_xyz(tags[name]) for name in (b"rXYZ", b"gXYZ", b"bXYZ")], axis=1))
        else:
            return None
        names = {_name(curve) for curve in curves}
    except (KeyError, ValueError, IndexError, ArithmeticError, struct.error, np.linalg.LinAlgError):
        return None
    if matrix is not None and not np.isfinite(matrix).all():
        return None
    encoding = names.pop() if len(names) == 1 else None
    if encoding is not None:
        curves = (lambda signal: decode_signal(signal, encoding),)
    near = matrix is None or np.allclose(matrix, np.eye(3), rtol=0, atol=_SAME_MATRIX)
    return Profile(curves, None if near else matrix, encoding)


def _tags(data: bytes) -> dict[bytes, bytes]:
    """The tagged elements of a profile by signature (section 7.3)."""
    if data[36:40] != b"acsp":
        raise ValueError("no profile")
    (count,) = struct.unpack_from(">I", data, 128)
    rows = [struct.unpack_from(">4sII", data, 132 + 12 * index) for index in range(min(count, _MOST_TAGS))]
    return {name: data[start : start + size] for name, start, size in rows}


def _fixed(data: bytes, start: int, count: int) -> Float[np.ndarray, "count"]:
    """So many s15Fixed16Numbers: 16 bits before the point, 16 after (section 4.6)."""
    return np.array(struct.unpack_from(f">{count}i", data, start)) / 65536


def _xyz(data: bytes) -> Float[np.ndarray, "3"]:
    """An element of XYZType (section 10.31)."""
    if data[:4] != b"XYZ ":
        raise ValueError("no XYZ")
    return _fixed(data, 8, 3)


def _curve(data: bytes) -> Curve:
    """The curve of an element of curveType or parametricCurveType (sections 10.6 and 10.18)."""
    if data[:4] == b"para":
        (kind,) = struct.unpack_from(">H", data, 8)
        return _parametric(kind, [float(number) for number in _fixed(data, 12, (1, 3, 4, 5, 7)[kind])])
    if data[:4] != b"curv":
        raise ValueError("no curve")
    (count,) = struct.unpack_from(">I", data, 8)
    if count == 0:
        return _power(1.0)
    if count == 1:
        return _power(struct.unpack_from(">H", data, 12)[0] / 256)
    table = np.frombuffer(data, ">u2", count, 12) / 65535
    return lambda signal: _along(signal, table)


def _power(exponent: float) -> Curve:
    encoding = gamma(exponent)
    return lambda signal: decode_signal(signal, encoding)


def _along(signal: np.ndarray, table: Float[np.ndarray, "count"]) -> np.ndarray:
    """Linear interpolation in a table over [0, 1]; past its ends it goes on straight."""
    inside = np.interp(signal, np.linspace(0, 1, len(table)), table)
    slopes = (table[[1, -1]] - table[[0, -2]]) * (len(table) - 1)
    return inside + slopes[0] * np.minimum(signal, 0) + slopes[1] * np.maximum(signal - 1, 0)


def _parametric(kind: int, numbers: list[float]) -> Curve:
    """Y = (a X + b)^g + e for X >= d, else c X + f; the kinds 0 to 3 leave out some of the numbers (table 68)."""
    if kind == 0:
        return _power(numbers[0])
    g, a, b, *rest = numbers
    if kind == 4:
        c, d, e, f = rest
    elif kind == 3:
        (c, d), e, f = rest, 0.0, 0.0
    else:
        e = f = rest[0] if kind == 2 else 0.0
        c, d = 0.0, -b / a
    return lambda signal: np.where(signal >= d, np.maximum(a * signal + b, 0) ** g + e, c * signal + f)


def _name(curve: Curve) -> str | None:
    """The name of the encoding that the curve is, if any: sRGB's in a table of 1024 numbers is sRGB.

    Raises ValueError for a curve that does not rise.
    """
    signal = np.linspace(0, 1, 257)
    light = curve(signal)
    if not (np.isfinite(light).all() and (np.diff(light) >= 0).all() and light[0] < light[-1]):
        raise ValueError("a curve that does not rise")
    middle = light[128]
    exponent = np.log(middle) / np.log(0.5) if 0 < middle < 1 else 1.0
    for name in (*_KNOWN, gamma(round(float(exponent), 5))):
        if np.abs(light - decode_signal(signal, name)).max() < _SAME_CURVE:
            return name
    return None
