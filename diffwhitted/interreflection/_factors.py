"""Form factors with visibility (Hearn and Baker 14-82): F_jk, the share of what leaves patch j that arrives at k.

Where two patches see each other whole the integral over k is Lambert's formula, and that over j a quadrature, finer for
those that are near each other. Where something may stand between them rays decide how much of it is seen. The two ways
round are made one, so that A_j F_jk = A_k F_kj holds to rounding, and the rows of patches from which no ray escapes are
balanced to the sum 1 by factors d_j d_k, which keep it so.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ._lambert import overlap, quadrature, towards_each, towards_polygons
from ._patches import SAMPLES, Patches, Places

NEAR, BESIDE = 4.0, 1.5
"""In the sum of the radii of two patches: nearer than this the integral over one of them is a quadrature, and a finer
one."""
FIRST = 4
"""So many rays look whether two patches see each other; where they disagree, `SAMPLES`."""
ESCAPES = 64
"""Rays that look whether light can leave the scene from a patch."""
ROUNDS = 300
CONTACT = 1e-6
"""Patches whose planes are so near to each other, as a share of the scene, touch."""
LEAST = 0.5
"""A row of a smaller sum is not balanced: its light goes to what has no patches."""

Sees = Callable[[Places, np.ndarray, np.ndarray], Bool[np.ndarray, "n"]]
"""Does each place see the point (n, 3) on the surface of the chart of this number (n,)?"""


Escapes = Callable[[Places], Bool[np.ndarray, "n"]]
"""Does a ray from each place along its normal, which is any direction, meet nothing?"""
NEARLY = 0.02
"""Where nobody is asked, sums of rows so near to 1 are those of closed ones."""


@dataclass(frozen=True, eq=False)
class Factors:
    """Form factors of patches, and what sites gather of them."""

    patches: Patches
    matrix: Float[np.ndarray, "n n"]
    gather: Float[np.ndarray, "s n"]
    """What share of the light that could arrive at a site comes from each patch: incident light over its B."""
    closed: Bool[np.ndarray, "n"]
    """No light from there leaves the scene."""
    residual: float
    """The most by which the sum of a closed row is off 1; 0 without closed rows."""
    imbalance: float
    """The same before rows were balanced: how good the factors are in themselves."""


def form_factors(patches: Patches, sees: Sees | None, escapes: Escapes | None) -> Factors:
    """`sees`: None where nothing can stand between two patches. `escapes`: of rays (directions in place of normals),
    whether they meet nothing; None: it is not asked, and the sums of rows tell.
    """
    area = patches.area
    # Send light from the middle of each patch to all others, and from many points to those that are near.
    direct = towards_polygons(patches.centre, patches.normal, patches.loops)
    apart = np.linalg.norm(patches.centre[:, None] - patches.centre[None], axis=-1)
    reach = patches.radius[:, None] + patches.radius[None]
    facing = (direct > 0) | (direct.T > 0)
    for low, high, halved in ((BESIDE, NEAR, 0), (0.0, BESIDE, 1)):
        j, k = np.nonzero((apart < high * reach) & (apart >= low * reach) & (facing | (low == 0)))
        direct[j, k] = _integrated(patches, j, k, halved)
    np.fill_diagonal(direct, 0)
    # Make both ways round one, and ask what stands between.
    exchanged = _both_ways(patches, area[:, None] * direct, apart >= NEAR * reach)
    if sees is not None:
        j, k = np.nonzero(np.triu(exchanged > 0, 1))
        seen = _seen(patches, j, k, sees)
        exchanged[j, k] *= seen
        exchanged[k, j] = exchanged[j, k]
    _in_contact(patches, apart, reach, exchanged)
    # Balance the rows of patches from which nothing escapes, and those that give away more than there is.
    sums = exchanged.sum(axis=1) / area
    closed = _closed(patches, escapes, sums) & (sums > LEAST)
    balanced = _balanced(exchanged, area, closed)
    matrix = balanced / area[:, None]
    off = np.where(closed, abs(matrix.sum(axis=1) - 1), 0).max(initial=0)
    return Factors(
        patches, matrix, _gathered(patches, sees, closed), closed, float(off),
        float(np.where(closed, abs(sums - 1), 0).max(initial=0)),
    )  # fmt: skip


def _integrated(patches: Patches, j, k, halved: int) -> Float[np.ndarray, "p"]:
    """The mean over patch j of what arrives at k, for pairs."""
    points, weights = quadrature(patches.loops, halved)
    found = np.zeros(len(j))
    for q in range(weights.shape[1]):
        there = weights[j, q] > 0
        seen = _in_front(points[j, q], k, patches) & there
        share = towards_each(points[j[seen], q], patches.normal[j[seen]], patches.loops[k[seen]])
        found[seen] += weights[j[seen], q] * share
    return found


def _in_front(points: Float[np.ndarray, "p 3"], k: Int[np.ndarray, "p"], patches: Patches) -> Bool[np.ndarray, "p"]:
    return np.sum((points - patches.centre[k]) * patches.normal[k], axis=1) > 0


def _in_contact(patches: Patches, apart, reach, exchanged) -> None:
    """Add what patches of two objects that lie upon each other, face to face, have in common: all light from there goes
    to the other.
    """
    level = CONTACT * float(np.ptp(patches.loops.reshape(-1, 3), axis=0).max())
    facing = patches.normal @ patches.normal.T < -1 + CONTACT
    facing &= patches.object[:, None] != patches.object[None]
    rise = patches.normal @ patches.centre.T - np.sum(patches.normal * patches.centre, axis=1)[:, None]
    for j, k in zip(*np.nonzero(np.triu(facing & (abs(rise) < level) & (apart < reach), 1)), strict=True):
        way = patches.loops[j, 1] - patches.loops[j, 0]
        axes = np.stack([way, np.cross(patches.normal[j], way)], axis=1) / np.linalg.norm(way)
        exchanged[j, k] += overlap(patches.loops[j] @ axes, patches.loops[k][::-1] @ axes)
        exchanged[k, j] = exchanged[j, k]


def _both_ways(patches: Patches, sent, far) -> Float[np.ndarray, "n n"]:
    """A_j F_jk from A_j times the share from the middle of j, which is exact over k: the mean of both ways round, and
    of those that are far from each other their product over what middle sends to middle, which is exact over both to
    the second order in their size.
    """
    position, normal, area = patches.centre, patches.normal, patches.area
    mean = 0.5 * (sent + sent.T)
    square = np.sum(position**2, axis=1)
    square = np.maximum(square[:, None] + square[None] - 2 * position @ position.T, 1e-100)
    rise = normal @ position.T - np.sum(normal * position, axis=1)[:, None]
    between = rise * rise.T / (np.pi * square * square) * (area[:, None] * area[None])
    product = sent * sent.T / np.maximum(between, 1e-100)
    good = far & (rise > 0) & (rise.T > 0) & (abs(product - mean) < 0.2 * mean)
    return np.where(good, product, mean)


def _seen(patches: Patches, j: Int[np.ndarray, "p"], k: Int[np.ndarray, "p"], sees: Sees) -> Float[np.ndarray, "p"]:
    """How much of each of two patches the other sees, by rays between points of both."""
    seen = np.zeros(len(j))
    step = SAMPLES // FIRST
    for q in range(FIRST):
        seen += _ray(patches, j, k, q * step, (q * step + step * (q % 2) + step // 2) % SAMPLES, sees)
    seen /= FIRST
    mixed = np.flatnonzero((seen > 0) & (seen < 1))
    more = np.zeros(len(mixed))
    for q in range(SAMPLES):
        more += _ray(patches, j[mixed], k[mixed], q, (7 * q + 3) % SAMPLES, sees)
    seen[mixed] = more / SAMPLES
    return seen


def _ray(patches: Patches, j, k, one: int, other: int, sees: Sees):
    at = patches.samples
    return sees(Places(at.position[j, one], at.normal[j, one], at.chart[j]), at.position[k, other], at.chart[k])


def _gathered(patches: Patches, sees: Sees | None, closed: Bool[np.ndarray, "n"]) -> Float[np.ndarray, "s n"]:
    """Of sites of faces from which no light escapes the sum is made 1."""
    sites = patches.sites
    found = towards_polygons(sites.position, sites.normal, patches.loops)
    if sees is not None:
        s, k = np.nonzero(found > 0)
        seen, at = np.zeros(len(s)), patches.samples

        def ray(rows, q):
            chosen = Places(sites.position[s[rows]], sites.normal[s[rows]], sites.chart[s[rows]])
            return sees(chosen, at.position[k[rows], q], at.chart[k[rows]])

        every = np.arange(len(s))
        for q in range(0, SAMPLES, SAMPLES // FIRST):
            seen += ray(every, q)
        seen /= FIRST
        mixed = np.flatnonzero((seen > 0) & (seen < 1))
        seen[mixed] = sum(ray(mixed, q).astype(float) for q in range(SAMPLES)) / SAMPLES
        found[s, k] *= seen
    whole = np.ones(len(patches.charts), bool)
    np.logical_and.at(whole, patches.chart, closed)
    sums = found.sum(axis=1)
    return found / np.where(whole[sites.chart] & (sums > 0), sums, 1)[:, None]


def _closed(patches: Patches, escapes: Escapes | None, sums) -> Bool[np.ndarray, "n"]:
    """Does no ray that leaves a patch meet nothing?"""
    if escapes is None:
        return abs(sums - 1) < NEARLY
    number = np.arange(ESCAPES)
    radius = np.sqrt((number + 0.5) / ESCAPES)
    turn = 2 * np.pi * ((number * 0.6180339887498949) % 1)
    local = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], axis=-1)
    at, found = patches.samples, np.zeros(patches.count, bool)
    for q in range(ESCAPES):
        place, normal = at.position[:, q % SAMPLES], at.normal[:, q % SAMPLES]
        least = np.eye(3)[abs(normal).argmin(axis=1)]
        across = np.cross(least, normal)
        across = across / np.linalg.norm(across, axis=1, keepdims=True)
        way = local[q, 0] * across + local[q, 1] * np.cross(normal, across) + local[q, 2] * normal
        found |= escapes(Places(place, way, at.chart))
    return ~found


def _balanced(exchanged, area, closed):
    """d_j S_jk d_k, whose closed rows have the sums A_j and others no more (Sinkhorn and Knopp), for symmetric S."""
    scale = np.ones(len(area))
    for _ in range(ROUNDS):
        sums = scale * (exchanged @ scale)
        factor = np.sqrt(area / np.maximum(sums, 1e-300))
        factor = np.where(closed, factor, np.minimum(factor, 1))
        scale = scale * factor
        if abs(factor - 1).max() < 1e-8:
            break
    return exchanged * scale[:, None] * scale[None]
