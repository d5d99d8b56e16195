"""Which triangles of meshes meet at a side."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Int

from ..geometry import BITS
from ..numerics._recent import Recent
from ..records import is_traced
from ._facets import places_of

_KEPT: Recent[tuple[np.ndarray, np.ndarray]] = Recent(8)
"""Of meshes that come again."""


def shared_sides(meshes: Sequence[Any]) -> tuple[Int[np.ndarray, "e"], Int[np.ndarray, "e"]]:
    """All sides of the triangles of meshes, those that two triangles share once: their numbers (see `side_of`), and the
    third corner of the other triangle, numbered in the same way, -1 where there is none.

    A side of three triangles and more is one of each of them alone. Known vertices in one place are one.
    """
    content = [part for mesh in meshes for part in (mesh.faces, _known(mesh.vertices))]
    return _KEPT.of(content, lambda: _shared(meshes))


def _known(vertices):
    return f"{len(vertices)} that are traced" if is_traced(vertices) else vertices


def _shared(meshes: Sequence[Any]) -> tuple[Int[np.ndarray, "e"], Int[np.ndarray, "e"]]:
    faces, first = [], 0
    for mesh in meshes:
        own = np.asarray(mesh.faces)
        own = own if is_traced(mesh.vertices) else places_of(np.asarray(mesh.vertices))[own]
        faces.append(own + first)
        first += len(mesh.vertices)
    ends = np.concatenate(faces).astype(np.int64)
    start, end = ends.ravel(), np.roll(ends, -1, axis=1).ravel()
    triangle, place = np.divmod(np.arange(start.size), 3)
    number = triangle + (place << BITS)
    # Sort sides by their ends, so that those that are shared follow one another.
    key = np.minimum(start, end) * first + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    begins = np.flatnonzero(np.diff(key[order], prepend=-1))
    many = np.diff(begins, append=key.size)
    pairs = begins[many == 2]
    alone = np.setdiff1d(np.arange(key.size), np.concatenate([pairs, pairs + 1]), assume_unique=True)
    one, other = order[pairs], order[pairs + 1]
    third = triangle[other] + ((place[other] + 2) % 3 << BITS)
    side = np.concatenate([number[one], number[order[alone]]])
    return side.astype(np.int32), np.concatenate([third, np.full(alone.size, -1)]).astype(np.int32)
