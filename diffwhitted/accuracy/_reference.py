"""What some pixels look like by far more work than any setting takes, and how far that is from converged."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ._blur import CONVERGED_BLUR, blurs
from ._knobs import Settings
from ._lamps import CONVERGED_SAMPLES, has_sized_lights
from ._materials import CONVERGED_ROUGHNESS_SAMPLES, has_fresnel, has_gloss
from ._tracer import Tracer

CUTOFF = 2.0**-16
"""Branches that carry less than this are not followed, however deep."""
LEVELS = ((4, 12), (8, 16), (16, 24), (32, 32))
"""Trees along the side of a pixel, and depth: of all pixels for the first two, then of fewer and fewer."""
AT_ONCE = 2**20
"""Trees; more of them would only take more memory."""
SHARE = 1 / 8
"""Each further level is for so large a part of the pixels of the one before, those that it changed most."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Two pictures of the same pixels: `pixels`, and `before`, in which each pixel has a quarter of its trees, less
    deep.
    """

    pixels: np.ndarray
    """(n, 3), linear Rec. 709 RGB, float64."""
    before: np.ndarray
    level: int
    """The last of `LEVELS` that was reached."""
    variant: Settings
    """What was asked of lamps and materials in place of what the scene says."""
    rays: int

    @property
    def difference(self) -> float:
        """RMSE of one against the other."""
        return rmse(self.pixels, self.before)

    def __str__(self) -> str:
        (least, depth), (most, deepest) = LEVELS[1], LEVELS[self.level]
        finer = f", up to {most} x {most} and depth {deepest} where that changes most" if self.level > 1 else ""
        lamps, fresnel, normals = self.variant.light_samples, self.variant.fresnel, self.variant.roughness_samples
        lamps = "" if lamps is None else f", {lamps} points a lamp"
        fresnel = "" if fresnel is None else f", fresnel {fresnel}"
        normals = "" if normals is None else f", {normals} normals a tree"
        blur = self.variant.blur_samples
        blur = "" if blur is None else f", {blur} places in the lens a tree"
        return f"{least} x {least} filtered trees a pixel of depth {depth}{finer}{lamps}{fresnel}{normals}{blur}"


def reference(
    tracer: Tracer,
    pixels: np.ndarray | None = None,
    wanted: Callable[[np.ndarray], float] = lambda pixels: 0.0,
    on_work: Callable[[float], None] | None = None,
    variant: Settings | None = None,
) -> Reference:
    """The picture of these pixels (all by default), refined until a quarter of the trees differs by `wanted(picture)`
    (RMSE) or less.

    Filtered trees of 1/k of a pixel converge to the area of the pixel as k grows, and faster than points do. Meshes
    that are not flat are shaded by Phong, whatever they state.
    `variant`: its knobs of lamps, materials and camera stand in place of what the scene says. `on_work` is called with
    the part of the work that is done, if all levels are needed. Raises `CapacityError` as `Tracer` does.
    """
    pixels, variant = tracer.all_pixels if pixels is None else pixels, variant or Settings()
    sizes = [len(pixels), *(max(1, int(len(pixels) * SHARE**n)) for n in range(len(LEVELS) - 1))]
    work = [size * side**2 for size, (side, _) in zip(sizes, LEVELS, strict=True)]
    which, rays = np.arange(len(pixels)), 0
    refined = before = np.zeros((len(pixels), 3))
    for level, (size, (side, depth)) in enumerate(zip(sizes, LEVELS, strict=True)):
        if level > 1:
            change = np.abs(refined[which] - before[which]).max(axis=-1)
            which = np.sort(which[np.argpartition(-change, size - 1)[:size]])
        before, refined = before.copy(), refined.copy()
        before[which] = refined[which]
        parts = np.array_split(which, -(-size * side**2 // AT_ONCE))
        for number, part in enumerate(parts):
            found = tracer.trace_spread(
                replace(variant, depth=depth, cutoff=CUTOFF, footprint=side, shading="phong"), pixels[part]
            )
            refined[part], rays = found.pixels, rays + found.rays
            if on_work is not None:
                on_work((sum(work[:level]) + work[level] * (number + 1) / len(parts)) / sum(work))
        if level and rmse(refined, before) <= wanted(refined):
            break
    return Reference(refined, before, level, variant, rays)


def converged_settings(tracer: Tracer) -> Settings:
    """What a reference asks of lamps, materials and camera, where they have it."""
    return Settings(
        light_samples=CONVERGED_SAMPLES if has_sized_lights(tracer.scene) else None,
        fresnel="exact" if has_fresnel(tracer.scene) else None,
        roughness_samples=CONVERGED_ROUGHNESS_SAMPLES if has_gloss(tracer.scene) else None,
        blur_samples=CONVERGED_BLUR if blurs(tracer.camera) else None,
    )


def rmse(one: ArrayLike, other: ArrayLike) -> float:
    """Root of the mean of the squared differences, over pixels and channels alike."""
    return float(np.sqrt(np.mean(np.square(np.asarray(one, np.float64) - np.asarray(other, np.float64)))))
