"""Weights of branches that change with the angle of incidence.

    mirror ray F k_s,   transmitted ray (1 - F k_s) k_t,   past the critical angle k_s + (1 - k_s) k_t

for a dielectric (Parker et al. 3.1, where k_s = k_t = 1: k_t = 1 - k_s "by conservation of energy"); the last is what
the first becomes where F = 1 and nothing is transmitted. Of a metal the mirror ray carries F0 + (1 - F0) (1 - cos)**5
with F0 = k_s (Schlick 1994).
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Array, Float, Int

from ..illumination import SurfacePoint
from ..numerics._vector import Vec3, where
from ..optics import fresnel_exact, fresnel_schlick, rising
from ..scene import FRESNEL_MODELS
from ._arrival import MIRROR, TOTAL, TRANSMITTED

Weights = Callable[[SurfacePoint, Int[Array, "n"], Vec3], Vec3]
Passed = tuple[np.ndarray, np.ndarray]
"""Weights (3,) of the mirror ray and of the transmitted one."""


def dielectric(model: str) -> Weights:
    """What the points of one model make of the weight of a branch."""
    reflectance = {"exact": fresnel_exact, "schlick": fresnel_schlick}[model]

    def weighs(point: SurfacePoint, branch: Int[Array, "n"], factor: Vec3) -> Vec3:
        k_s, k_t = point.colour("k_s"), point.colour("k_t")
        mirrored = k_s * reflectance(point.cosine, point.eta, point.radicand)
        mine = point.models["fresnel"] == FRESNEL_MODELS.index(model)
        factor = where(mine & (branch == MIRROR), mirrored, factor)
        factor = where(mine & (branch == TRANSMITTED), k_t - mirrored * k_t, factor)
        return where(mine & (branch == TOTAL), k_s + k_t - k_s * k_t, factor)

    return weighs


def metal(point: SurfacePoint, branch: Int[Array, "n"], factor: Vec3) -> Vec3:
    """What metals make of the weight of a branch."""
    mine = point.models["fresnel"] == FRESNEL_MODELS.index("metal")
    return where(mine & (branch == MIRROR), coloured(point.colour("k_s"), point.cosine), factor)


def coloured(straight: Vec3, cosine: Float[Array, "n"]) -> Vec3:
    """Schlick's polynomial of a colour."""
    return Vec3(*(rising(channel, cosine) for channel in (straight.x, straight.y, straight.z)))


def dielectric_extremes(k_s: np.ndarray, k_t: np.ndarray) -> tuple[Passed, ...]:
    """The weights are linear in F, so that no angle passes on more than those of F = 0 or of F = 1."""
    return (np.zeros(3), k_t), (k_s, np.maximum(1 - k_s, 0) * k_t)


def metal_extremes(k_s: np.ndarray, k_t: np.ndarray) -> tuple[Passed, ...]:
    """Straight on, and along the surface."""
    return (k_s, k_t), (np.ones(3), k_t)
