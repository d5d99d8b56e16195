"""Which texels each pixel sees, and how much: the sparse Jacobian of pictures in the texels of a map.

Texels that lie `apart` from each other in both ways are moved together, one such set after the other, so that a pixel
answers to one of them at most where what it sees of the map is smaller. To know to which, the same set is moved twice
more, each texel by an amount of its own: the ratio of the answers is that amount. A pixel that sees the map in several
places far from each other, past a mirror say, has ratios that are nobody's; it is tried again with the texels further
apart, and left out in the end.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy import sparse

from ..problem._map_view import MapView

APART = (4, 8)
"""Texels between those that are moved together, at first and where pixels were left."""
WAYS = 12
"""Directions at a time."""
SMALLEST = 1e-4
"""An answer of a smaller share of what a pixel shows of the map is none."""
FEW = 0.01
"""Share of the pixels that may be left before the texels are moved further apart."""


@dataclass(frozen=True, eq=False)
class MapRows:
    """The Jacobian of one picture, a matrix a channel: a row for each pixel, row by row, a column for each texel."""

    channels: tuple[sparse.csr_array, ...]
    known: Bool[np.ndarray, "rows columns"]
    """The pixels whose rows are whole; those of the others are empty."""


def map_rows(view: MapView, texels, apart: Sequence[int] = APART) -> MapRows:
    """The rows of a picture at these texels."""
    for distance in apart:
        found = _rows(view, texels, distance)
        if (~found.known).mean() <= FEW:
            break
    return found


def _rows(view: MapView, texels, apart: int) -> MapRows:
    """With the texels so far apart that are moved together."""
    height, width = texels.shape[:2]
    row, column = np.mgrid[:height, :width]
    # A distance that does not divide the size would bring two together across the seam of a map that repeats.
    sets = _stripes(height, apart)[row] * (_stripes(width, apart).max() + 1) + _stripes(width, apart)[column]
    amounts = _amounts(sets)
    ways = [np.where(sets == k, amount, 0) for k in range(sets.max() + 1) for amount in (np.ones_like(sets), *amounts)]
    answers = _answers(view, texels, ways).reshape(sets.max() + 1, 3, -1, 3)
    seen = abs(answers[:, 0]).sum(axis=0).max(axis=-1)
    parts, known = [], np.ones(answers.shape[2], bool)
    for number, (plain, first, second) in enumerate(answers):
        here = np.flatnonzero(abs(plain).max(axis=-1) > SMALLEST * np.maximum(seen, 1e-30))
        # Ask the channel that answers most which texel it is.
        loudest = abs(plain[here]).argmax(axis=-1)
        ratios = [a[here, loudest] / plain[here, loudest] for a in (first, second)]
        mine = np.flatnonzero(sets.ravel() == number)
        texel, sure = _nearest(ratios, mine, amounts.reshape(2, -1)[:, mine])
        known[here[~sure]] = False
        parts.append((here, texel, plain[here]))
    pixel, texel, value = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    whole = known[pixel]
    shape = answers.shape[2], height * width
    channels = tuple(sparse.csr_array((value[whole, c], (pixel[whole], texel[whole])), shape=shape) for c in range(3))
    return MapRows(channels, known.reshape(view.size))


def _amounts(sets: np.ndarray) -> Float[np.ndarray, "2 height width"]:
    """From 1/2 to 3/2, two for each texel, the first as far from each other within a set as so many can be."""
    random = np.random.default_rng(0)
    first, second = np.empty(sets.shape), random.uniform(0.5, 1.5, sets.shape)
    for number in range(sets.max() + 1):
        mine = sets == number
        first[mine] = 0.5 + random.permutation(np.arange(mine.sum()) + 0.5) / mine.sum()
    return np.stack([first, second])


def _stripes(size: int, apart: int) -> np.ndarray:
    """Numbers along one side of a map such that equal ones are at least `apart` from each other, also around it."""
    count = max(1, size // apart)
    edges = np.linspace(0, size, count + 1).astype(int)
    return np.concatenate([np.arange(stop - start) for start, stop in zip(edges[:-1], edges[1:], strict=True)])


def _answers(view: MapView, texels, ways: list[np.ndarray]) -> Float[np.ndarray, "ways pixels 3"]:
    """What the pixels answer to each way, all channels moved alike; in batches of one size."""
    dtype, found = texels.dtype, []
    for start in range(0, len(ways), WAYS):
        batch = ways[start : start + WAYS]
        batch = np.stack([*batch, *[np.zeros_like(batch[0], float)] * (WAYS - len(batch))])
        three = np.broadcast_to(batch[..., None], (*batch.shape, 3)).astype(dtype)
        found.append(view.along(texels, three)[: len(ways) - start])
    return np.concatenate(found).reshape(len(ways), -1, 3)


def _nearest(ratios: list[np.ndarray], mine: np.ndarray, amounts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the texels `mine` the one whose first amount is nearest to the first ratio, and whether the second agrees."""
    order = np.argsort(amounts[0])
    ascending = amounts[0][order]
    after = np.clip(np.searchsorted(ascending, ratios[0]), 1, len(mine) - 1) if len(mine) > 1 else None
    if after is None:
        place = np.zeros(len(ratios[0]), int)
    else:
        before = np.abs(ratios[0] - ascending[after - 1]) < np.abs(ratios[0] - ascending[after])
        place = order[np.where(before, after - 1, after)]
    sure = np.all([abs(r - a[place]) < 1e-4 * a[place] for r, a in zip(ratios, amounts, strict=True)], axis=0)
    return mine[place], sure
