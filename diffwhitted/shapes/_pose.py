"""Where an object stands: scaled, turned and moved, for every kind of object.

What a transform makes of an object is read from its rows: points go along, directions turn, lengths grow. So a kind
need not know of transforms, unless its numbers are others.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np

from .._errors import SceneError
from ..records import Row, changed, is_traced, listed

POSE: tuple[Row, ...] = (
    Row("scale", "number or vector", "Made so many times as large about the origin, along x, y and z where it is "
        "three numbers.", default=None, lowest=0, excluded=True, scale="log", moves="rays"),
    Row("rotate_deg", "vector", "Then turned about x, then y, then z, right-handed, degrees.", unit="deg", default=None,
        scale="unbounded", moves="rays"),
    Row("translate", "vector", "Then moved by so many metres.", unit="m", default=None, scale="unbounded",
        moves="rays"),
    Row("matrix", "matrix", "In place of the three: 4 rows of 4 numbers, the last one 0, 0, 0, 1.", default=None),
)  # fmt: skip
"""The keys that every object may have beside its own."""
NAMES = tuple(row.name for row in POSE)
VELOCITY = Row(
    "velocity", "vector", "Metres a second, while the shutter of a camera is open; it is stated where it is in the "
    "middle of that time.", unit="m/s", default=None, scale="unbounded", moves="rays", source="Cook et al. 1984, 3.5",
)  # fmt: skip
"""How it moves, in the coordinates of the scene: no transform turns it."""
EVEN = 1e-5
"""A matrix whose axes differ in length, or from a right angle, by no more than this share is even."""


def has_pose(record) -> bool:
    """Does an object have a transform? Asked of each of thousands, so without going through the record's class."""
    stated = object.__getattribute__(record, "__dict__").get
    turned = stated("rotate_deg") is not None or stated("scale") is not None
    return turned or stated("translate") is not None or stated("matrix") is not None


def stated_pose(place: str, **stated) -> dict[str, Any]:
    """The checked values of the keys, by name, None for those that are not stated. Raises `SceneError`."""
    found = {row.name: None if stated[row.name] is None else row.read(stated[row.name], place) for row in POSE}
    matrix = found["matrix"]
    if matrix is None:
        return found
    others = [name for name in NAMES[:3] if found[name] is not None]
    if others:
        raise SceneError(f"{place}: matrix and {', '.join(others)} are stated; allowed is the one or the others")
    if not is_traced(matrix):
        matrix = np.asarray(matrix)
        if (matrix[3] != (0, 0, 0, 1)).any():
            raise SceneError(f"{place}: matrix ends with the row {listed(matrix[3])}; allowed is [0, 0, 0, 1]")
        size = abs(matrix[:3, :3]).max() or 1.0
        if not np.linalg.det(matrix[:3, :3] / size) > 0:
            raise SceneError(
                f"{place}: matrix makes the object flat or mirrors it; allowed is a positive determinant of its first "
                "three rows and columns"
            )
    return found


def affine(record) -> tuple[Any, Any]:
    """The matrix (3, 3) and the shift (3,) of a record's transform: on the host, in float64, where all is known."""
    scale, turn, shift, matrix = (getattr(record, name) for name in NAMES)
    known = not any(map(is_traced, (scale, turn, shift, matrix)))
    if matrix is not None:
        matrix = np.asarray(matrix, np.float64) if known else matrix
        return matrix[:3, :3], matrix[:3, 3]
    own, dtype = (np, np.float64) if known else (jnp, None)
    linear = own.eye(3, dtype=dtype)
    if scale is not None:
        linear = linear * own.asarray(scale, dtype)
    if turn is not None:
        linear = _rotation(own, own.deg2rad(own.asarray(turn, dtype))) @ linear
    return linear, own.zeros(3, dtype) if shift is None else own.asarray(shift, dtype)


def _rotation(own, angles):
    """About x, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = own.cos(angles), own.sin(angles)
    rows = (
        (cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz),
        (cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz),
        (-sy, sx * cy, cx * cy),
    )
    return own.stack([own.stack(row) for row in rows])


def by_rows(record, linear, shift, place: str):
    """A copy of a record that a transform has taken along, row by row.

    Raises `SceneError` where it has lengths or directions, and the transform is not even.
    """
    rows = [row for row in record.ROWS if row.numeric and row.name not in NAMES]
    even = [row for row in rows if row.kind == "direction" or (row.kind == "number" and row.unit == "m")]
    growth = even_growth(record, linear, place) if even else 1.0
    placed = {}
    for row in rows:
        value = getattr(record, row.name)
        if value is None:
            continue
        if row.kind in ("vector", "vectors") and row.unit == "m":
            placed[row.name] = value @ linear.T + shift
        elif row.kind == "direction":
            placed[row.name] = linear @ value
        elif row in even:
            placed[row.name] = growth * value
    return changed(record, **placed)


def even_growth(record, linear, place: str):
    """By what an even transform makes lengths grow. Raises `SceneError` for one that is known and not even."""
    if is_traced(linear):
        return jnp.cbrt(jnp.linalg.det(linear))
    square = linear.T @ linear
    growth_squared = np.trace(square) / 3
    if abs(square - growth_squared * np.eye(3)).max() > EVEN * growth_squared:
        advice = ' For an ellipsoid, use type = "quadric"' if record.TYPE == "sphere" else ""
        stated = "matrix" if record.scale is None else f"scale = {listed(record.scale)}"
        raise SceneError(
            f"{place}: {stated} is not the same along all axes, and a {record.written_type()} has no numbers for what "
            f"comes of it; allowed is one number.{advice}"
        )
    return np.sqrt(growth_squared)
