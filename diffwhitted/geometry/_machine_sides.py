"""The search for outlines of `_sides` as machine code: the same tests and the same answers."""

import numpy as np
from numba import njit

from ._machine_calls import argument, result, to_be_done
from ._sides import LONG


@njit(inline="always")
def _enters(rows, at, ox, oy, oz, dx, dy, dz, ix, iy, iz, reach, growth, limit):
    """Does the ray come within its footprint of a box, before the limit?"""
    half, slack = rows.dtype.type(0.5), rows.dtype.type(1 + 8 * np.finfo(rows.dtype).eps)
    lx, ly, lz, hx, hy, hz = rows[at], rows[at + 1], rows[at + 2], rows[at + 3], rows[at + 4], rows[at + 5]
    # The far side of the box is no further than this.
    far = abs((lx + hx) * half - ox) + abs((ly + hy) * half - oy) + abs((lz + hz) * half - oz)
    around = reach + growth * (far + half * (hx - lx + hy - ly + hz - lz))
    lx, ly, lz, hx, hy, hz = lx - around, ly - around, lz - around, hx + around, hy + around, hz + around
    # An empty box is met by nothing: sides by the sign of the direction, not of the difference.
    near = max(
        max(((hx if ix < 0 else lx) - ox) * ix, ((hy if iy < 0 else ly) - oy) * iy),
        max(((hz if iz < 0 else lz) - oz) * iz, rows.dtype.type(0)),
    )
    far = min(
        min(((lx if ix < 0 else hx) - ox) * ix, ((ly if iy < 0 else hy) - oy) * iy), ((lz if iz < 0 else hz) - oz) * iz
    )
    return near <= far * slack and near < limit


@njit(inline="always")
def _all_alike(creases, rows, cones, node, ox, oy, oz):
    """Do all faces in a node turn to the eye, or all away, so that no outline is there?"""
    at = 6 * node
    cosine, sine = cones[at + 3], cones[at + 4]
    if cosine < 0 or (creases and cones[at + 5] != 0):
        return False
    half = rows.dtype.type(0.5)
    box = 8 * node
    hx, hy, hz = rows[box + 3] - rows[box], rows[box + 4] - rows[box + 1], rows[box + 5] - rows[box + 2]
    x, y, z = rows[box] + half * hx - ox, rows[box + 1] + half * hy - oy, rows[box + 2] + half * hz - oz
    around = rows.dtype.type(0.501) * np.sqrt(hx * hx + hy * hy + hz * hz)
    along = x * cones[at] + y * cones[at + 1] + z * cones[at + 2]
    across = np.sqrt(max(x * x + y * y + z * z - along * along, rows.dtype.type(0)))
    # The normal of the cone that is turned most to the place where the sign changes.
    return abs(along) * cosine - across * sine > around


@njit(inline="always")
def _outline(members, at, ox, oy, oz):
    """Seen from there, do both triangles lie on one side of it?"""
    ax, ay, az = members[at] - ox, members[at + 1] - oy, members[at + 2] - oz
    bx, by, bz = members[at + 3] - ox, members[at + 4] - oy, members[at + 5] - oz
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    one = nx * (members[at + 6] - ox) + ny * (members[at + 7] - oy) + nz * (members[at + 8] - oz)
    other = nx * (members[at + 9] - ox) + ny * (members[at + 10] - oy) + nz * (members[at + 11] - oz)
    return (one > 0 and other > 0) or (one < 0 and other < 0)


@njit(inline="always")
def _touches(members, at, passed, ray, rays, ends):
    """Has it an end in common with a side that the ray runs past?"""
    for k in range(ends):
        px, py, pz = passed[3 * k * rays + ray], passed[(3 * k + 1) * rays + ray], passed[(3 * k + 2) * rays + ray]
        for own in (at, at + 3):
            if members[own] == px and members[own + 1] == py and members[own + 2] == pz:
                return True
    return False


@njit(inline="always")
def _follow(
    creases, rows, cones, leaf, members, flags, ox, oy, oz, dx, dy, dz,
    limit, skip, reach, growth, passed, ends, ray, rays,
):  # fmt: skip
    """One ray through the tree: the side and its distance."""
    leaves, zero, one = leaf.shape[0], rows.dtype.type(0), rows.dtype.type(1)
    wide = rows.dtype.type(1e30)
    ix, iy, iz = one / dx if dx != 0 else wide, one / dy if dy != 0 else wide, one / dz if dz != 0 else wide
    best, found, away = one + one, np.int32(-1), zero
    node, pending = 1, 0
    if not _enters(rows, 8, ox, oy, oz, dx, dy, dz, ix, iy, iz, reach, growth, limit):
        return found, away
    while True:
        if node < leaves:
            # Look into both children, and go down to the first that is met.
            left = _enters(rows, 16 * node, ox, oy, oz, dx, dy, dz, ix, iy, iz, reach, growth, limit)
            right = _enters(rows, 16 * node + 8, ox, oy, oz, dx, dy, dz, ix, iy, iz, reach, growth, limit)
            left = left and not _all_alike(creases, rows, cones, 2 * node, ox, oy, oz)
            right = right and not _all_alike(creases, rows, cones, 2 * node + 1, ox, oy, oz)
            if left or right:
                pending = pending << 1 | (left and right)
                node = node << 1 | (not left)
                continue
        else:
            # Measure how closely the side passes.
            number, at = leaf[node - leaves], (node - leaves) * 12
            if number >= 0 and skip != flags[3 * number] and (skip < 0 or skip != flags[3 * number + 1]):
                ax, ay, az = members[at] - ox, members[at + 1] - oy, members[at + 2] - oz
                ex, ey, ez = (
                    members[at + 3] - members[at],
                    members[at + 4] - members[at + 1],
                    members[at + 5] - members[at + 2],
                )
                ahead, longest = ex * dx + ey * dy + ez * dz, ex * ex + ey * ey + ez * ez
                square = longest - ahead * ahead
                share = ahead * (ax * dx + ay * dy + az * dz) - (ax * ex + ay * ey + az * ez)
                share = min(max(share / (square if square > 0 else one), zero), one)
                px, py, pz = ax + share * ex, ay + share * ey, az + share * ez
                distance = px * dx + py * dy + pz * dz
                px, py, pz = px - distance * dx, py - distance * dy, pz - distance * dz
                apart, around = px * px + py * py + pz * pz, reach + growth * distance
                around = around * around
                if distance > 0 and distance < limit and apart < around * min(best, one):
                    # Outlines come before creases.
                    outline = _outline(members, at, ox, oy, oz)
                    crease = creases and flags[3 * number + 2] != 0 and longest > rows.dtype.type(LONG * LONG) * around
                    share = apart / around + (zero if outline else one)
                    there = (outline or crease) and share < best
                    if there and not _touches(members, at, passed, ray, rays, ends):
                        best, found, away = share, number, distance
        # Go up to the sibling that is still to be seen.
        if pending == 0:
            return found, away
        while pending & 1 == 0:
            node >>= 1
            pending >>= 1
        node ^= 1
        pending ^= 1


@njit(inline="always")
def _run(frame, real):
    """All rays of a call."""
    creases, rows, leaf = argument(frame, 0, np.int32)[0] != 0, argument(frame, 1, real), argument(frame, 2, np.int32)
    members, flags = argument(frame, 3, real), argument(frame, 4, np.int32)
    ox, oy, oz = argument(frame, 5, real), argument(frame, 6, real), argument(frame, 7, real)
    dx, dy, dz = argument(frame, 8, real), argument(frame, 9, real), argument(frame, 10, real)
    limit, skip = argument(frame, 11, real), argument(frame, 12, np.int32)
    reach, growth = argument(frame, 13, real), argument(frame, 14, real)
    passed, cones, rays = argument(frame, 15, real), argument(frame, 16, real), ox.shape[0]
    ends = passed.shape[0] // (3 * rays)
    found, away = result(frame, 0, np.int32), result(frame, 1, real)
    for k in range(rays):
        found[k], away[k] = -1, 0
        if limit[k] > 0:
            found[k], away[k] = _follow(
                creases, rows, cones, leaf, members, flags, ox[k], oy[k], oz[k], dx[k], dy[k], dz[k],
                limit[k], skip[k], reach[k], growth[k], passed, ends, k, rays,
            )  # fmt: skip


def side_kernel(real):
    """What XLA calls, in one precision."""

    def call(frame):
        if to_be_done(frame):
            _run(frame, real)
        return 0

    return call
