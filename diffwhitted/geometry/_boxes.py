"""A balanced tree of boxes over the surfaces of a family, made by the same few lines on the host or within a program.

The surfaces are sorted so that each half of the list lies on one side of the other, along the longest axis of what the
list spans, and each half likewise. The tree over such a list needs no links: node k has the children 2 k and 2 k + 1,
the root is 1, and the leaves are the surfaces in their order. Geometry that is traced, or that has changed since a tree
was made, is sorted anew within the program.
"""

from functools import reduce
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..numerics._vector import Vec3

ROUNDINGS = 4
NOTHING_HERE = -1
ROW = 8
"""Numbers a node: low x, y, z, high x, y, z of its box and two to spare, so that the boxes of both children fill a line
of the cache."""


class BoxTree(eqx.Module):
    """The tree: arrays only, arguments of a program."""

    rows: Float[Array, "numbers"]
    """`ROW` numbers for each of the nodes 0 .. 2 m - 1, m the number of leaves; that of node 0 means nothing."""
    leaf: Int[Array, "leaves"]
    """The surface in each leaf, -1 in the room to spare."""
    members: Float[Array, "numbers"] | None = None
    """The numbers of the surfaces in the order of the leaves, where there is machine code for their kind."""
    cones: Float[Array, "numbers"] | None = None
    """Of a tree of sides: what the normals on both sides of them have in common (see `Sides.cones`)."""

    @property
    def leaves(self) -> int:
        return self.leaf.shape[0]

    def around(self) -> tuple[Vec3, Vec3]:
        """The corners of the box around all."""
        return Vec3(*self.rows[ROW : ROW + 3]), Vec3(*self.rows[ROW + 3 : ROW + 6])


def boxes_over(low: Any, high: Any, members: Any = None) -> BoxTree:
    """The tree over surfaces with these boxes, whose corners are (n, 3) each; on the host where they are NumPy's.

    `members`: the numbers of each surface, (n, numbers), or None (see `AbstractSurfaces.numbers`).

    Raises nothing: a surface whose box is empty or not finite is met by no ray.
    """
    xp: Any = np if isinstance(low, np.ndarray) else jnp
    if xp is jnp:
        low, high = jax.lax.stop_gradient((low, high))
    count = low.shape[0]
    levels = max(count - 1, 0).bit_length()
    spare = ((0, 2**levels - count), (0, 0))
    # Fill up to a power of two with boxes that nothing meets.
    low = xp.pad(low, spare, constant_values=np.inf)
    high = xp.pad(high, spare, constant_values=-np.inf)
    leaf = xp.where(xp.arange(2**levels) < count, xp.arange(2**levels), NOTHING_HERE).astype(np.int32)
    there = (xp.isfinite(low) & xp.isfinite(high) & (low <= high)).all(axis=1, keepdims=True)
    middle = xp.where(there, 0.5 * (xp.where(there, low, 0) + xp.where(there, high, 0)), np.inf)
    low, high = xp.where(there, low, np.inf), xp.where(there, high, -np.inf)
    order = _sorted(xp, middle, levels)
    low, high, leaf = low[order], high[order], leaf[order]
    # Put each two boxes into one, level by level.
    nodes = [xp.concatenate([low, high, xp.zeros_like(low[:, :2])], axis=1)]
    for _ in range(levels):
        pairs = nodes[-1].reshape(-1, 2, ROW)
        least, most = pairs[:, :, :3].min(axis=1), pairs[:, :, 3:6].max(axis=1)
        nodes.append(xp.concatenate([least, most, pairs[:, 0, 6:]], axis=1))
    nodes.append(xp.zeros_like(nodes[-1]))
    if members is not None:
        members = members[xp.maximum(leaf, 0)].reshape(-1)
    return BoxTree(xp.concatenate(nodes[::-1]).reshape(-1), leaf, members)


def outwards(low: Vec3, high: Vec3) -> tuple[Vec3, Vec3]:
    """The corners of boxes, moved outwards by a few roundings of their coordinates."""
    coordinates = (low.x, low.y, low.z, high.x, high.y, high.z)
    some = ROUNDINGS * jnp.finfo(low.dtype).eps * reduce(jnp.maximum, map(abs, coordinates))
    margin = Vec3(some, some, some)
    return low - margin, high + margin


def _sorted(xp: Any, middle, levels: int):
    """The order of points (2**levels, 3), infinite ones last, in which every aligned half is split along its longest
    axis.
    """
    columns = [middle[:, k] for k in range(3)]
    order = xp.arange(middle.shape[0])
    for level in range(levels):
        parts = [column.reshape(2**level, -1) for column in columns]
        with np.errstate(invalid="ignore"):
            span = xp.stack([part.max(axis=1) - part.min(axis=1) for part in parts])
        longest = span.argmax(axis=0)[:, None]
        along = xp.where(longest == 0, parts[0], xp.where(longest == 1, parts[1], parts[2]))
        within = _halved(xp, along)
        order, *columns = (
            xp.take_along_axis(one.reshape(2**level, -1), within, axis=1).reshape(-1) for one in (order, *columns)
        )
    return order


def _halved(xp: Any, values):
    """Places of values (parts, n) such that none of the first half of a part is larger than one of the second half."""
    half = values.shape[1] // 2
    return np.argpartition(values, half, axis=1) if xp is np else xp.argsort(values, axis=1)
