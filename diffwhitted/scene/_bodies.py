"""Bodies that polygons make up, and which of their faces are turned inside out."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import jax
import numpy as np

from ..records import is_traced
from ..shapes import AbstractObject

SAME = 1e-6
"""Corners no further apart than this share of their coordinates are one."""
NAMED = 4
"""So many objects are named in a message."""


@dataclass(frozen=True)
class _Body:
    """Faces that close a volume: each of their sides is that of two."""

    faces: list[int]
    turned: list[int]
    """Those whose vertices run clockwise seen from outside."""
    low: np.ndarray
    high: np.ndarray

    def within(self, other: "_Body") -> bool:
        return bool((self.low > other.low).all() and (self.high < other.high).all())


def turned_faces(objects: Sequence[AbstractObject], glass: Collection[str]) -> Iterator[str]:
    """What is wrong with closed bodies of glass some of whose polygons show their inner side outwards, a sentence each.

    `glass`: names of the transparent materials. Polygons that close nothing, such as a pane, have no inside. A cavity
    within a body of the same material is turned rightly.
    """
    for material in sorted(glass):
        mine = [thing for thing in objects if thing.material == material]
        known = [thing for thing in mine if not any(map(is_traced, jax.tree.leaves(thing)))]
        faces = [(thing, flat[2]) for thing in known if (flat := thing.flat()) is not None and flat[2] is not None]
        bodies = list(_bodies([corners for _, corners in faces]))
        for body in bodies:
            all_of_it = len(body.turned) == len(body.faces)
            cavity = all_of_it and any(body.within(other) for other in bodies if other is not body)
            if body.turned and not cavity:
                yield _sentence([faces[k][0].name for k in body.turned], material, all_of_it)


def _sentence(names: list[str], material: str, all_of_it: bool) -> str:
    listed = ", ".join(map(repr, names[:NAMED])) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")
    some, they = ("objects", "they are") if len(names) > 1 else ("object", "it is")
    body = "the closed body that they make up" if all_of_it else f"the closed body that {they} part of"
    return (
        f"{some} {listed} of material {material!r}: seen from outside {body}, the vertices run clockwise, so light "
        "is bent there as if it left the body where it enters; reverse the order of these vertices"
    )


def _bodies(faces: Sequence[np.ndarray]) -> Iterator[_Body]:
    """The closed bodies among faces of corners (v, 3)."""
    if len(faces) < 4:
        return
    # Number the corners, and find the faces on each side of a face, with the way in which they run along it.
    points = np.concatenate(faces)
    numbers = np.unique(np.round(points / (SAME * (abs(points).max() or 1))), axis=0, return_inverse=True)[1].ravel()
    corners = np.split(numbers, np.cumsum([len(face) for face in faces])[:-1])
    beside: dict[tuple[int, int], list[tuple[int, bool]]] = {}
    for k, around in enumerate(corners):
        for a, b in zip(around.tolist(), np.roll(around, -1).tolist(), strict=True):
            if a != b:
                beside.setdefault((min(a, b), max(a, b)), []).append((k, a < b))
    neighbours: dict[int, list[tuple[int, bool]]] = {k: [] for k in range(len(faces))}
    is_open = set()
    for along in beside.values():
        if len(along) != 2:
            is_open |= {k for k, _ in along}
            continue
        (i, one), (j, other) = along
        neighbours[i].append((j, one == other))
        neighbours[j].append((i, one == other))
    # Walk over each group of neighbours, turning those that run against the ones before.
    seen: set[int] = set()
    for first in neighbours:
        if first in seen:
            continue
        turned, ahead = {first: False}, [first]
        while ahead:
            i = ahead.pop()
            for j, against in neighbours[i]:
                if j not in turned:
                    turned[j] = turned[i] != against
                    ahead.append(j)
        seen |= turned.keys()
        if is_open.isdisjoint(turned):
            volume = sum((-1 if turned[k] else 1) * _volume(faces[k] - faces[first][0]) for k in turned)
            reach = np.concatenate([faces[k] for k in turned])
            wrong = sorted(k for k in turned if turned[k] != (volume < 0))
            yield _Body(sorted(turned), wrong, reach.min(axis=0), reach.max(axis=0))


def _volume(corners: np.ndarray) -> float:
    """Six times the volume between a face and the origin, positive where it runs counter-clockwise seen from beyond."""
    return float(corners[0] @ np.cross(corners[1:-1], corners[2:]).sum(axis=0))
