"""Elements of Mitsuba's XML."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from .._numbers import listed, text


def number(parent: Element, name: str, value: float) -> None:
    SubElement(parent, "float", name=name, value=text(value))


def whole(parent: Element, name: str, value: int) -> None:
    SubElement(parent, "integer", name=name, value=str(value))


def word(parent: Element, name: str, value: str) -> None:
    SubElement(parent, "string", name=name, value=value)


def colour(parent: Element, name: str, channels: Iterable[float]) -> None:
    SubElement(parent, "rgb", name=name, value=listed(channels, ", "))


def point(parent: Element, name: str, place: Iterable[float], kind: str = "point") -> None:
    SubElement(parent, kind, {"name": name, **dict(zip("xyz", map(text, place), strict=True))})


def placed(parent: Element, columns: np.ndarray) -> None:
    """`to_world` by its columns (4, 3): where the axes go, and the origin."""
    matrix = np.vstack([np.asarray(columns).T, (0, 0, 0, 1)])
    SubElement(SubElement(parent, "transform", name="to_world"), "matrix", value=listed(matrix.ravel()))
