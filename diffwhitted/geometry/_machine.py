"""The walk of `_walk` as machine code, which XLA calls itself on a CPU: for spheres and triangles.

numba compiles a kernel for each kind of surface and precision (see `_machine_calls`). The trees are the same, and so
are the answers; where numba is missing, `_walk` serves.
"""

from functools import partial

import numpy as np
from numba import njit

from ._compiled import ANY, COUNT
from ._machine_calls import argument, registered, result, to_be_done
from ._machine_sides import side_kernel


@njit(inline="always")
def _sphere(rows, at, ox, oy, oz, dx, dy, dz, on_it, inwards):
    """Distances of both crossings ahead, infinity where there is none."""
    none = rows.dtype.type(np.inf)
    cx, cy, cz, r = rows[at] - ox, rows[at + 1] - oy, rows[at + 2] - oz, rows[at + 3]
    middle = cx * dx + cy * dy + cz * dz
    qx, qy, qz = cx - dx * middle, cy - dy * middle, cz - dz * middle
    square = r * r - (qx * qx + qy * qy + qz * qz)
    if not square > 0:
        return none, none
    half = np.sqrt(square)
    near, far = middle - half, middle + half
    near = near if near > 0 and not on_it else none
    return near, (far if far > 0 and (not on_it or inwards) else none)


@njit(inline="always")
def _side(px, py, qx, qy):
    """Twice the area of a corner, the origin and another corner, the same for both triangles at an edge."""
    if px < qx or (px == qx and py < qy):
        return px * qy - py * qx
    return -(qx * py - qy * px)


@njit(inline="always")
def _triangle(rows, at, ox, oy, oz, dx, dy, dz, on_it, inwards):
    """Distance of the crossing ahead: Woop, Benthin and Wald 2013, without gaps between neighbours."""
    none = rows.dtype.type(np.inf)
    if on_it:
        return none, none
    a0, a1, a2 = rows[at] - ox, rows[at + 1] - oy, rows[at + 2] - oz
    b0, b1, b2 = rows[at + 3] - ox, rows[at + 4] - oy, rows[at + 5] - oz
    c0, c1, c2 = rows[at + 6] - ox, rows[at + 7] - oy, rows[at + 8] - oz
    # Turn the axes so that the ray runs along the last one most.
    x, y, z = abs(dx), abs(dy), abs(dz)
    if x > y and x > z:
        a0, a1, a2, b0, b1, b2, c0, c1, c2, dx, dy, dz = a1, a2, a0, b1, b2, b0, c1, c2, c0, dy, dz, dx
    elif y > z:
        a0, a1, a2, b0, b1, b2, c0, c1, c2, dx, dy, dz = a2, a0, a1, b2, b0, b1, c2, c0, c1, dz, dx, dy
    # Shear them so that it runs along that axis altogether.
    along = rows.dtype.type(1) / dz
    sx, sy = dx * along, dy * along
    ax, ay, bx, by, cx, cy = a0 - sx * a2, a1 - sy * a2, b0 - sx * b2, b1 - sy * b2, c0 - sx * c2, c1 - sy * c2
    u, v, w = _side(cx, cy, bx, by), _side(ax, ay, cx, cy), _side(bx, by, ax, ay)
    if (u < 0 or v < 0 or w < 0) and (u > 0 or v > 0 or w > 0):
        return none, none
    area = u + v + w
    if area == 0:
        return none, none
    distance = (u * a2 + v * b2 + w * c2) * along / area
    return (distance if distance > 0 else none), none


@njit(inline="always")
def _follow(
    round, width, mode, rows, leaf, members, flags, ox, oy, oz, dx, dy, dz, limit, skip, inwards, counts, ray, rays
):
    """One ray through the tree: distance, number and crossing of what it finds."""
    leaves, zero, one = leaf.shape[0], rows.dtype.type(0), rows.dtype.type(1)
    wide, slack = rows.dtype.type(1e30), one + 8 * rows.dtype.type(np.finfo(rows.dtype).eps)
    ix, iy, iz = one / dx if dx != 0 else wide, one / dy if dy != 0 else wide, one / dz if dz != 0 else wide
    # Of the six numbers of a box, those of the sides that the ray meets first, and last.
    nx, ny, nz = 3 if ix < 0 else 0, 4 if iy < 0 else 1, 5 if iz < 0 else 2
    fx, fy, fz = 3 - nx, 5 - ny, 7 - nz
    best, found, crossing = limit, np.int32(-1), np.int8(0)
    node, pending = 1, 0
    near = max(max((rows[8 + nx] - ox) * ix, (rows[8 + ny] - oy) * iy), max((rows[8 + nz] - oz) * iz, zero))
    far = min(min((rows[8 + fx] - ox) * ix, (rows[8 + fy] - oy) * iy), (rows[8 + fz] - oz) * iz)
    if not (near <= far * slack and near < best):
        return best, found, crossing
    while True:
        if node < leaves:
            # Look into both children.
            at = 16 * node
            near = max(max((rows[at + nx] - ox) * ix, (rows[at + ny] - oy) * iy), max((rows[at + nz] - oz) * iz, zero))
            far = min(min((rows[at + fx] - ox) * ix, (rows[at + fy] - oy) * iy), (rows[at + fz] - oz) * iz)
            left = near <= far * slack and near < best
            at += 8
            other = max(max((rows[at + nx] - ox) * ix, (rows[at + ny] - oy) * iy), max((rows[at + nz] - oz) * iz, zero))
            far = min(min((rows[at + fx] - ox) * ix, (rows[at + fy] - oy) * iy), (rows[at + fz] - oz) * iz)
            right = other <= far * slack and other < best
            # Go down to the nearer one, and remember the other one.
            if left or right:
                pending <<= 1
                node <<= 1
                if left and right:
                    pending |= 1
                    node += other < near
                else:
                    node += right
                continue
        else:
            # Meet the surface.
            number = leaf[node - leaves]
            if number >= 0 and (mode != ANY or flags[number] != 0):
                at = (node - leaves) * width
                if round:
                    near, far = _sphere(members, at, ox, oy, oz, dx, dy, dz, number == skip, inwards)
                else:
                    near, far = _triangle(members, at, ox, oy, oz, dx, dy, dz, number == skip, inwards)
                if mode == COUNT:
                    if flags[number] >= 0:
                        counts[flags[number] * rays + ray] += (near < limit) + (far < limit)
                elif min(near, far) < best:
                    best, found, crossing = min(near, far), number, np.int8(far < near)
                    if mode == ANY:
                        return best, found, crossing
        # Go up to the sibling that is still to be seen.
        if pending == 0:
            return best, found, crossing
        while pending & 1 == 0:
            node >>= 1
            pending >>= 1
        node ^= 1
        pending ^= 1


@njit(inline="always")
def _run(round, width, frame, real):
    """All rays of a call."""
    mode, rows, leaf = argument(frame, 0, np.int32)[0], argument(frame, 1, real), argument(frame, 2, np.int32)
    members, flags = argument(frame, 3, real), argument(frame, 4, np.int32)
    ox, oy, oz = argument(frame, 5, real), argument(frame, 6, real), argument(frame, 7, real)
    dx, dy, dz = argument(frame, 8, real), argument(frame, 9, real), argument(frame, 10, real)
    limit, skip, inwards = argument(frame, 11, real), argument(frame, 12, np.int32), argument(frame, 13, np.uint8)
    distance, found, crossing = result(frame, 0, real), result(frame, 1, np.int32), result(frame, 2, np.int8)
    counts, rays = result(frame, 3, np.int32), ox.shape[0]
    for k in range(counts.shape[0]):
        counts[k] = 0
    for k in range(rays):
        distance[k], found[k], crossing[k] = limit[k], -1, 0
        if limit[k] > 0:
            distance[k], found[k], crossing[k] = _follow(
                round, width, mode, rows, leaf, members, flags,
                ox[k], oy[k], oz[k], dx[k], dy[k], dz[k], limit[k], skip[k], inwards[k] != 0, counts, k, rays,
            )  # fmt: skip


def _kernel(round, width, real):
    """What XLA calls for a kind of surface, in one precision."""

    def call(frame):
        if to_be_done(frame):
            _run(round, width, frame, real)
        return 0

    return call


KINDS = {"sphere": partial(_kernel, True, 4), "triangle": partial(_kernel, False, 9), "side": side_kernel}
"""For spheres (centre and radius), triangles (three corners), and sides of triangles."""


def target(kind: str, dtype: str) -> str:
    """The name under which XLA calls the kernel for a kind of surface."""
    return registered(kind, dtype, KINDS[kind])
