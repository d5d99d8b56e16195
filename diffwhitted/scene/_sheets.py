"""Which objects touch in a whole surface: a block of glass on a block of water, a glass on its coaster.

Rounding must not decide which of two surfaces in one place a ray meets first, or whether it meets the second one at
all. So they are found before a picture is traced, in float64, and put in order: what the ray leaves, what is opaque,
what it enters (see `geometry/_sheets`).
"""

from collections.abc import Collection, Iterator, Sequence

import jax
import jax.numpy as jnp
import numpy as np

from ..geometry import Sheets
from ..records import is_traced
from ..shapes import AbstractObject

Sheet = tuple[tuple[str, bool], ...]
"""Objects with a surface in one place, by name, and whether its outer side is that of the first one."""
NEAR = 1e-6
"""Surfaces no further apart than this share of their coordinates are in one place: a few roundings of float32."""


def shared_sheets(objects: Sequence[AbstractObject], glass: Collection[str]) -> tuple[Sheet, ...]:
    """The sheets in which an object that is named in `glass` shares a surface, in part at least, with another one.

    What is traced touches nothing: nobody knows where it is. The glass is compared with all others.
    """
    known = [thing for thing in objects if not any(map(is_traced, jax.tree.leaves(thing)))] if glass else []
    sheets, names = [], [thing.name for thing in known]
    with jax.ensure_compile_time_eval():
        for kind in (_flat, _round):
            pairs = list(kind(known, [name in glass for name in names]))
            sheets += [tuple((names[k], same) for k, same in sheet.items()) for sheet in _joined(pairs)]
    return tuple(sheets)


def sheets_of(objects: Sequence[AbstractObject], shared: Sequence[Sheet], glass: Collection[str]) -> Sheets | None:
    """The same for the ray tree: the sheet of each object, its side, and its layer; None where nothing touches.

    The layers of a sheet run towards the outer side of its first object: glass whose outside is there, what is opaque,
    glass whose inside is there. Of the same kind the later one is the inner one.
    """
    if not shared:
        return None
    count = len(objects)
    number = {thing.name: k for k, thing in enumerate(objects)}
    sheet, facing, layer = np.full(count, -1, np.int32), np.ones(count, bool), np.zeros(count, np.int32)
    for which, members in enumerate(shared):
        for name, same in members:
            k = number[name]
            sheet[k], facing[k] = which, same
            layer[k] = 2 * count + k if name not in glass else count - k if same else 4 * count + k
    return Sheets(jnp.asarray(sheet), jnp.asarray(facing), jnp.asarray(layer))


Touching = Iterator[tuple[int, int, bool]]
"""Numbers of two objects, and whether their outer sides are the same."""


def _flat(objects: Sequence[AbstractObject], glass: Sequence[bool]) -> Touching:
    """Polygons and planes in one plane that overlap."""
    flats = [(k, flat) for k, thing in enumerate(objects) if (flat := thing.flat()) is not None]
    if len(flats) < 2 or not any(glass[k] for k, _ in flats):
        return
    # Take some points of each: its corners, or three of a plane without end.
    size = max((abs(corners).max() for _, (_, _, corners) in flats if corners is not None), default=1.0) or 1.0
    points = [_three(normal, offset, size) if corners is None else corners for _, (normal, offset, corners) in flats]
    most = max(map(len, points))
    points = np.stack([np.concatenate([p, np.repeat(p[:1], most - len(p), axis=0)]) for p in points])
    near = NEAR * abs(points).max(axis=(1, 2))
    for a, (i, (normal, offset, corners)) in enumerate(flats):
        if not glass[i]:
            continue
        apart = abs(points @ normal - offset).max(axis=1)
        for b in np.flatnonzero(apart <= near + near[a]):
            j, (other, _, others) = flats[b]
            if i != j and _overlap(normal, corners, others, near[a] + near[b]):
                yield i, j, bool(normal @ other > 0)


def _three(normal: np.ndarray, offset: float, size: float) -> np.ndarray:
    """Three points of a plane, as far apart as the scene is large."""
    along = np.cross(normal, np.eye(3)[abs(normal).argmin()])
    return normal * offset + size * np.stack([along * 0, along, np.cross(normal, along)])


def _overlap(normal: np.ndarray, one: np.ndarray | None, other: np.ndarray | None, near: float) -> bool:
    """Have two polygons of a plane some area in common? Told of their convex hulls, by separating lines."""
    if one is None or other is None:
        return True
    sides = np.concatenate([np.roll(corners, -1, axis=0) - corners for corners in (one, other)])
    across = np.cross(sides, normal)
    across = across[np.linalg.norm(across, axis=1) > near]
    across = across / np.linalg.norm(across, axis=1, keepdims=True)
    low, high = (np.stack([take(corners @ across.T, axis=0) for corners in (one, other)]) for take in (np.min, np.max))
    return bool((np.minimum(*high) - np.maximum(*low) > 4 * near).all())


def _round(objects: Sequence[AbstractObject], glass: Sequence[bool]) -> Touching:
    """Spheres in one place."""
    balls = [(k, thing.ball()) for k, thing in enumerate(objects) if thing.ROUND and thing.solid]
    if len(balls) < 2 or not any(glass[k] for k, _ in balls):
        return
    middles, radii = np.stack([middle for _, (middle, _) in balls]), np.asarray([radius for _, (_, radius) in balls])
    near = NEAR * (abs(middles).max(axis=1) + radii)
    for a, (i, _) in enumerate(balls):
        if glass[i]:
            apart = np.maximum(abs(middles - middles[a]).max(axis=1), abs(radii - radii[a]))
            yield from ((i, balls[b][0], True) for b in np.flatnonzero(apart <= near[a]) if b != a)


def _joined(pairs: Sequence[tuple[int, int, bool]]) -> list[dict[int, bool]]:
    """The groups that pairs make up, in order, each with the side of its members against that of the first."""
    beside: dict[int, list[tuple[int, bool]]] = {}
    for i, j, same in pairs:
        beside.setdefault(i, []).append((j, same))
        beside.setdefault(j, []).append((i, same))
    groups, seen = [], set()
    for first in sorted(beside):
        if first in seen:
            continue
        group, ahead = {first: True}, [first]
        while ahead:
            i = ahead.pop()
            for j, same in beside[i]:
                if j not in group:
                    group[j] = group[i] == same
                    ahead.append(j)
        seen |= group.keys()
        groups.append(dict(sorted(group.items())))
    return groups
