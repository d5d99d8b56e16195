"""Shapes of "The Ray Tracer Challenge", a function a kind: unit spheres, cubes and so on under a transform."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...shapes import read_parts
from ..others import _placed as placed
from ..others._found import Found
from ._nodes import Entry

Keys = dict[str, Entry]
CUBE = np.asarray([[-1.0] * 3, [1.0] * 3])
ENDLESS_CYLINDER = (1, 0, 1, 0, 0, 0, 0, 0, 0, -1)
ENDLESS_CONE = (1, -1, 1, 0, 0, 0, 0, 0, 0, 0)
USUAL = {"add", "transform", "material", "shadow", "children"}


def _sphere(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    found.add(placed.sphere(matrix, np.zeros(3), 1.0), None, "sphere", material, entry.place())


def _plane(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    found.add(placed.plane(matrix, (0, 1, 0), 0.0), None, "plane", material, entry.place())


def _cube(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    found.add(placed.box(matrix, *CUBE), None, "cube", material, entry.place())


def _ends(entry: Entry, keys: Keys) -> tuple[float, float, bool] | None:
    """From where to where, and whether it is closed; None without any end."""
    ends = [keys[key].number(key) if key in keys else None for key in ("min", "max")]
    capped = "closed" in keys and keys["closed"].truth("closed")
    low, high = ends
    if low is None and high is None:
        return None
    if low is None or high is None:
        raise entry.error("it has one end alone; allowed are min and max, or neither")
    if not low < high:
        raise entry.error(f"min = {low:g} is not below max = {high:g}")
    return low, high, capped


def _cylinder(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    ends = _ends(entry, keys)
    if ends is None:
        made = placed.quadric(matrix, ENDLESS_CYLINDER)
    else:
        low, high, capped = ends
        made = placed.frustum(matrix, (0, low, 0), (0, high, 0), 1.0, 1.0, capped)
    found.add(made, None, "cylinder", material, entry.place())


def _cone(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    """Its radius is its height, to both sides of the tip."""
    ends = _ends(entry, keys)
    if ends is None:
        return found.add(placed.quadric(matrix, ENDLESS_CONE), None, "cone", material, entry.place())
    low, high, capped = ends
    spans = [(low, 0.0), (0.0, high)] if low < 0 < high else [(low, high)]
    for base, top in spans:
        made = placed.frustum(matrix, (0, base, 0), (0, top, 0), abs(base), abs(top), capped)
        found.add(made, None, "cone", material, entry.place())


def _points(entry: Entry, keys: Keys, names: str) -> np.ndarray:
    missing = [f"{names}{k}" for k in (1, 2, 3) if f"{names}{k}" not in keys]
    if missing:
        raise entry.error(f"the triangle has no {missing[0]}")
    return np.stack([keys[f"{names}{k}"].numbers(f"{names}{k}") for k in (1, 2, 3)])


def _triangle(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    made = placed.polygon(matrix, _points(entry, keys, "p"))
    found.add(made, None, "triangle", material, entry.place())


def _smooth_triangle(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    made = placed.mesh(matrix, _points(entry, keys, "p"), [[0, 1, 2]], _points(entry, keys, "n"))
    found.add(made, None, "triangle", material, entry.place())


def _obj(found: Found, entry: Entry, keys: Keys, matrix: np.ndarray, material: str) -> None:
    """The triangles of a file in the folder of the scene."""
    if "file" not in keys:
        raise entry.error("obj has no file")
    stated = keys["file"].word("file")
    folder = Path(found.source).parent
    path = (folder / stated).resolve()
    if not path.is_relative_to(folder.resolve()) or path.suffix.lower() != ".obj":
        raise keys["file"].error(f"file {stated[:80]!r}; allowed is an OBJ file in the folder of the scene")
    for part in read_parts(str(path), entry.place()):
        made = placed.mesh(matrix, part.vertices, part.faces, part.normals)
        found.add(made, path.stem, "mesh", material, entry.place())


SHAPES: dict[str, Callable[[Found, Entry, Keys, np.ndarray, str], None]] = {
    "sphere": _sphere,
    "plane": _plane,
    "cube": _cube,
    "cylinder": _cylinder,
    "cone": _cone,
    "triangle": _triangle,
    "smooth-triangle": _smooth_triangle,
    "obj": _obj,
}
"""Each adds its objects to what was found."""
KNOWN_KEYS = USUAL | {"min", "max", "closed", "file"} | {f"{name}{k}" for name in "pn" for k in (1, 2, 3)}
