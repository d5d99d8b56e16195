"""Form factors of a small surface towards polygons, by Lambert's formula, and convex polygons cut by planes.

F = -1/(2 pi) sum over the sides of gamma_i n.(v_i x v_(i+1)) / |v_i x v_(i+1)|, v_i the way from the point to corner i,
gamma_i the angle between two of them (Baum, Rushmeier and Winget 1989, eq. 7): the integral of cos cos / (pi r^2) over
the polygon, exact. On the host, in float64.
"""

from functools import reduce

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..numerics._vector import Vec3, cross, dot, where

TINY = 1e-300
LEVEL = 1e-9
"""What rises above a plane by less than this share of its distance lies in it."""
PAIRS = 1 << 15
"""So many points and polygons are looked at in one go: one program for all scenes."""


def towards_polygons(
    points: Float[np.ndarray, "m 3"], normals: Float[np.ndarray, "m 3"], loops: Float[np.ndarray, "n v 3"]
) -> Float[np.ndarray, "m n"]:
    """What share of the light that leaves each point (unit normal) arrives at each convex polygon, nothing in between.

    `loops`: corners counter-clockwise seen from in front; shorter ones repeat their last corner. What lies behind the
    point's plane is cut off; a polygon that is seen from behind gets nothing.
    """
    found = np.zeros((len(points), len(loops)))
    centre, facing, _ = centres_of(loops)
    corners = np.swapaxes(loops, 0, 1)
    rows = max(1, 32 * PAIRS // max(len(loops), 1))
    for start in range(0, len(points), rows):
        x, n = points[start : start + rows], normals[start : start + rows]
        offset = np.sum(n * x, axis=1)[:, None]
        seen = x @ facing.T - np.sum(facing * centre, axis=1) > 0
        above = np.zeros_like(seen)
        for corner in corners:
            above |= n @ corner.T - offset > 0
        row, column = np.nonzero(seen & above)
        found[start + row, column] = towards_each(x[row], n[row], loops[column])
    return found


def towards_each(
    points: Float[np.ndarray, "p 3"], normals: Float[np.ndarray, "p 3"], loops: Float[np.ndarray, "p v 3"]
) -> Float[np.ndarray, "p"]:
    """The same of one polygon a point."""
    found = np.zeros(len(points))
    for start in range(0, len(points), PAIRS):
        part = slice(start, start + PAIRS)
        ways, normal = loops[part] - points[part, None], normals[part]
        room = PAIRS - len(normal)
        ways = np.pad(ways, ((0, room), (0, max(4, loops.shape[1]) - loops.shape[1]), (0, 0)), mode="edge")
        with jax.enable_x64(True), jax.ensure_compile_time_eval():
            shares = _shares(jnp.asarray(ways.T), jnp.asarray(np.pad(normal, ((0, room), (0, 0)), mode="edge").T))
        found[part] = np.maximum(np.asarray(shares), 0)[: len(normal)]
    return found


@jax.jit
def _shares(ways: Float[Array, "3 v p"], normal: Float[Array, "3 p"]) -> Float[Array, "p"]:
    """Side by side of polygons, after what lies behind the plane of the point is cut off."""
    corners = [Vec3(*ways[:, k]) for k in range(ways.shape[1])]
    up_is = Vec3(*normal)
    far = reduce(jnp.maximum, [dot(corner, corner) for corner in corners])
    heights = [dot(up_is, corner) for corner in corners]
    up = [height > LEVEL * jnp.sqrt(far) for height in heights]
    total, nowhere = jnp.zeros_like(far), up_is * 0
    left = back = nowhere
    for k, here in enumerate(corners):
        there, up_here, up_there = corners[k - len(corners) + 1], up[k], up[k - len(corners) + 1]
        crosses, rise = up_here != up_there, heights[k] - heights[k - len(corners) + 1]
        share = jnp.clip(jnp.where(crosses, heights[k] / jnp.where(crosses & (rise != 0), rise, 1), 0), 0, 1)
        at = here + (there - here) * share
        side = _side(where(up_here, here, at), where(up_there, there, at), up_is)
        total = total + jnp.where(up_here | up_there, side, 0)
        # Remember where the outline goes below the plane, and where it comes back.
        left, back = where(up_here & ~up_there, at, left), where(~up_here & up_there, at, back)
    return -(total + _side(left, back, up_is)) / (2 * jnp.pi)


def _side(start: Vec3, end: Vec3, normal: Vec3):
    across = cross(start, end)
    sine = jnp.sqrt(dot(across, across))
    return jnp.arctan2(sine, dot(start, end)) * dot(across, normal) / jnp.maximum(sine, TINY)


def overlap(one: Float[np.ndarray, "v 2"], other: Float[np.ndarray, "w 2"]) -> float:
    """The area that two convex polygons, counter-clockwise, have in common."""
    for k in range(len(other)):
        start, way = other[k], other[(k + 1) % len(other)] - other[k]
        size = np.linalg.norm(way)
        if size > 0 and len(one):
            way = way / size
            turned = (one - start) @ np.stack([way, [-way[1], way[0]]], axis=1)
            one = cut(turned, 1, 0.0, True) @ np.stack([way, [-way[1], way[0]]]) + start
    return area_of(one)


def cut(loop: Float[np.ndarray, "v 2"], axis: int, at: float, above: bool) -> Float[np.ndarray, "w 2"]:
    """The part of a convex polygon on one side of a line along the other axis (Sutherland and Hodgman)."""
    if not len(loop):
        return loop
    sign = 1.0 if above else -1.0
    height = sign * (loop[:, axis] - at)
    kept = []
    for k in range(len(loop)):
        here, there = height[k], height[(k + 1) % len(loop)]
        if here >= 0:
            kept.append(loop[k])
        if (here > 0 > there) or (here < 0 < there):
            kept.append(loop[k] + (loop[(k + 1) % len(loop)] - loop[k]) * here / (here - there))
    return np.asarray(kept).reshape(-1, 2)


def area_of(loop: Float[np.ndarray, "v 2"]) -> float:
    """Positive where it runs counter-clockwise."""
    x, y = loop[:, 0], loop[:, 1]
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))) if len(loop) > 2 else 0.0


def padded(loops: list[np.ndarray]) -> Float[np.ndarray, "n v 3"]:
    """Polygons of several lengths in one array, the last corner repeated."""
    longest = max((len(loop) for loop in loops), default=3)
    if not loops:
        return np.zeros((0, longest, 3))
    return np.stack([np.concatenate([loop, np.repeat(loop[-1:], longest - len(loop), axis=0)]) for loop in loops])


def triangles_of(loops: Float[np.ndarray, "n v 3"]) -> tuple[np.ndarray, np.ndarray]:
    """The fan of triangles (n, v - 2, 3, 3) of each polygon, and their areas as shares of its own (n, v - 2)."""
    first = np.repeat(loops[:, None, 0], loops.shape[1] - 2, axis=1)
    fan = np.stack([first, loops[:, 1:-1], loops[:, 2:]], axis=2)
    size = np.linalg.norm(np.cross(fan[:, :, 1] - fan[:, :, 0], fan[:, :, 2] - fan[:, :, 0]), axis=-1)
    return fan, size / size.sum(axis=1, keepdims=True)


def spread(loops: Float[np.ndarray, "n v 3"], count: int) -> Float[np.ndarray, "n c 3"]:
    """So many points evenly over each polygon, of the same weight (a rank-1 lattice)."""
    fan, share = triangles_of(loops)
    k = np.arange(count)
    along, across = (k + 0.5) / count, (0.5 + k * 0.6180339887498949) % 1
    ends = np.cumsum(share, axis=1)
    which = np.minimum((along[None, :, None] >= ends[:, None, :-1]).sum(axis=2), share.shape[1] - 1)
    rows = np.arange(len(loops))[:, None]
    begin = ends[rows, which] - share[rows, which]
    within = np.clip((along - begin) / np.maximum(share[rows, which], TINY), 0, 1)
    root = np.sqrt(within)[..., None]
    corner, other = fan[rows, which], across[None, :, None]
    return corner[..., 0, :] * (1 - root) + (corner[..., 1, :] * (1 - other) + corner[..., 2, :] * other) * root


_GAUSS = np.asarray(
    [[0.445948490915965, 0.108103018168070], [0.091576213509771, 0.816847572980459]]
), np.asarray([0.223381589678011, 0.109951743655322])  # fmt: skip


def quadrature(loops: Float[np.ndarray, "n v 3"], halved: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, q, 3) and weights (n, q) of sum 1 for means over polygons: Dunavant's six of degree 4 in each
    triangle, or in each of the four by four that it is cut into, `halved` times.
    """
    fan, share = triangles_of(loops)
    for _ in range(halved):
        a, b, c = (fan[..., k, :] for k in range(3))
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        fan = np.concatenate([np.stack(part, axis=-2) for part in parts], axis=1)
        share = np.concatenate([share / 4] * 4, axis=1)
    points, weights = [], []
    for (side, top), weight in zip(*_GAUSS, strict=True):
        for k in range(3):
            mix = np.full(3, side)
            mix[k] = top
            points.append(np.einsum("ntck,c->ntk", fan, mix))
            weights.append(share * weight)
    return np.concatenate(points, axis=1), np.concatenate(weights, axis=1)


def centres_of(loops: Float[np.ndarray, "n v 3"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres of gravity (n, 3), unit normals (n, 3) and areas (n,)."""
    fan, share = triangles_of(loops)
    middle = np.einsum("ntck,nt->nk", fan, share / 3)
    away = loops - middle[:, None]
    double = np.cross(away, np.roll(away, -1, axis=1)).sum(axis=1)
    size = np.linalg.norm(double, axis=1)
    return middle, double / np.maximum(size, TINY)[:, None], size / 2


def radii_of(loops: Float[np.ndarray, "n v 3"], middle: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n"]:
    """How far the furthest corner lies from the middle."""
    return np.linalg.norm(loops - middle[:, None], axis=2).max(axis=1)
