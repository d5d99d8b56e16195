"""Checkerboards of other programs, whatever way they are turned, as far as ours can be so."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...scene import AbstractObject, Disc, Plane, Polygon

ENDLESS = 1e4
"""An axis with cells so many times as large as the smallest is not counted."""
EVEN = 1e-6
NEAR = 1e-5
"""Part of a cell that is rounding."""


@dataclass(frozen=True, eq=False)
class Board:
    """The first colour where floor((x - corner) / size), summed over the axes, is even."""

    colours: np.ndarray
    """(2, 3)."""
    size: float
    axes: str
    corner: np.ndarray
    swapped: bool = False
    """The second colour lies there instead."""

    def key(self) -> tuple:
        numbers = (*np.ravel(self.colours).tolist(), self.size, *self.corner.tolist())
        return (*numbers, self.axes, self.swapped)

    def painted(self, colours) -> "Board":
        """The same cells in other colours."""
        return Board(np.asarray(colours, float), self.size, self.axes, self.corner, self.swapped)


def board_of(colours, matrix: np.ndarray, axes: str = "xyz") -> Board | None:
    """The board of cells of 1 along `axes` of a pattern that a transform (4, 4) puts into the scene. None where its
    axes are none of the scene's, or its cells not square.
    """
    found: dict[str, tuple[float, float]] = {}
    for axis in axes:
        along = matrix[:3, "xyz".index(axis)]
        towards = int(abs(along).argmax())
        if abs(np.delete(along, towards)).max() > EVEN * abs(along).max():
            return None
        found["xyz"[towards]] = float(along[towards]), float(matrix[towards, 3])
    smallest = min(abs(step) for step, _ in found.values())
    if len(found) < len(axes) or not smallest > 0:
        return None
    # What lies within one cell all over the scene is not counted, but where it lies is.
    counted = {axis: pair for axis, pair in found.items() if abs(pair[0]) < ENDLESS * smallest}
    odd = sum(int(np.floor(-start / step)) for axis, (step, start) in found.items() if axis not in counted)
    if any(abs(abs(step) - smallest) > EVEN * smallest for step, _ in counted.values()):
        return None
    # floor(-x) is -floor(x) - 1.
    odd += sum(step < 0 for step, _ in counted.values())
    corner = np.zeros(3)
    for axis, (_, start) in counted.items():
        corner["xyz".index(axis)] = start
    return Board(np.asarray(colours, float), smallest, "".join(sorted(counted)), corner, bool(odd % 2))


def simplified(board: Board, wearers: Iterable[AbstractObject]) -> tuple[Board, np.ndarray]:
    """A board whose corner is the origin, as far as can be, and the corner that is left.

    An axis along which all wearers share one place need not be counted; a corner moved by a whole cell is the board
    with the colours swapped.
    """
    axes, odd, corner = board.axes, int(board.swapped), board.corner.copy()
    flat = [_level(thing) for thing in wearers]
    for k, axis in enumerate("xyz"):
        if axis not in axes:
            continue
        places = {None if level is None or level[0] != axis else level[1] for level in flat}
        place = next(iter(places)) if len(places) == 1 else None
        if place is not None and len(axes) > 1 and len(board.axes) > 1:
            axes, away = axes.replace(axis, ""), (place - corner[k]) / board.size
            odd, corner[k] = odd + int(np.floor(away + NEAR)), 0.0
            continue
        cells = round(corner[k] / board.size)
        rest = corner[k] - cells * board.size
        odd += cells
        corner[k] = 0.0 if abs(rest) < NEAR * board.size else rest
    return Board(board.colours, board.size, axes, corner, bool(odd % 2)), corner


def _level(thing: AbstractObject) -> tuple[str, float] | None:
    """The axis that a flat object lies across, and where."""
    if not isinstance(thing, (Plane, Polygon, Disc)):
        return None
    if isinstance(thing, Plane):
        normal, offset = thing.half_space()
    else:
        normal, offset, _ = thing.flat()
    k = int(abs(normal).argmax())
    if abs(np.delete(normal, k)).max() > EVEN:
        return None
    return "xyz"[k], float(offset / normal[k])
