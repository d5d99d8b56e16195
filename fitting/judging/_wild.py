"""Wild pixels: hot ones, fireflies, dust, what no noise of the others' distribution allows.

A pixel is wild where a channel of its residual is beyond what the others' robust scale allows by far, and beyond what
the render varies by around it, so that no edge that is a little off counts as wild.
"""

from collections.abc import Sequence

import numpy as np

from .._result import WildPixel
from ..problem._target import CheckedTarget
from ..problem._whole_pictures import brightness, of_used

BEYOND = 8.0
"""Robust standard deviations."""
FEW = 0.01
"""Share of the pixels; more are no exception, but the model's or the noise's way."""
CARRY = 0.9
"""Share of the sum of squares from which on a few wild pixels rule the fit, and are left out."""
ALIKE = 0.02
"""Share of the largest square that theirs are at least."""
ABSURD = 1e6
"""A pixel so many times brighter than the brightest hundredth of its picture is no light."""
RESOLVED = 64.0
"""Units in the last place of a picture below which a residual is rounding."""
MEDIAN = 1.4826


def wild_of(
    targets: Sequence[CheckedTarget], pictures: Sequence[np.ndarray], eps: float
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Which pixels of each target are wild, (height, width), and by how many deviations all are off."""
    residual = [np.abs(p - t.image) for p, t in zip(pictures, targets, strict=True)]
    used = [t.mask > 0 for t in targets]
    rounding = RESOLVED * eps * max(brightness(targets), 1e-30)
    everything = of_used(targets, residual)
    # Where nothing is to be seen there is nothing to be off by.
    told = everything[everything > rounding]
    scale = max(MEDIAN * float(np.median(told)) if 2 * len(told) > len(everything) ** 0.5 else 0.0, rounding)
    sizes, wild = [], []
    for r, picture, where in zip(residual, pictures, used, strict=True):
        size = np.where(where, ((r - _range(picture)) / scale).max(axis=-1), 0)
        sizes.append(size)
        wild.append(size > BEYOND)
    if sum(int(w.sum()) for w in wild) > FEW * sum(int(where.sum()) for where in used):
        wild = [np.zeros_like(w) for w in wild]
    return wild, sizes


def ruling(targets: Sequence[CheckedTarget], pictures: Sequence[np.ndarray], eps: float) -> list[np.ndarray] | None:
    """The wild pixels of each target that carry nearly all that is left over; None where no few do."""
    _, sizes = wild_of(targets, pictures, eps)
    squares = [((p - t.image) ** 2).sum(axis=-1) * t.mask for p, t in zip(pictures, targets, strict=True)]
    largest = max(float(s.max()) for s in squares)
    # They may have led the fit astray, so that others are off too: take those that are far off beside these.
    ruled = [(z > BEYOND) & (s > ALIKE * largest) for z, s in zip(sizes, squares, strict=True)]
    carried = sum(float(s[r].sum()) for s, r in zip(squares, ruled, strict=True))
    few = sum(int(r.sum()) for r in ruled) <= FEW * sum(int((t.mask > 0).sum()) for t in targets)
    return ruled if few and carried > CARRY * sum(float(s.sum()) for s in squares) > 0 else None


def absurd(targets: Sequence[CheckedTarget]) -> list[np.ndarray] | None:
    """The pixels that are no light, (height, width) for each target, where there are a few; else None."""
    found = []
    for t in targets:
        size = np.abs(t.image).max(axis=-1)
        if not (t.mask > 0).any():
            found.append(np.zeros(t.mask.shape, bool))
            continue
        bright = float(np.percentile(size[t.mask > 0], 99 * (1 - FEW)))
        found.append((size > ABSURD * max(bright, 1e-30)) & (t.mask > 0) & (bright > 0))
    return found if any(f.any() for f in found) else None


def wild_pixels(
    targets: Sequence[CheckedTarget], left_out: Sequence[np.ndarray], pictures: Sequence[np.ndarray], eps: float
) -> tuple[WildPixel, ...]:
    """All wild pixels of the targets as they were given, the worst first."""
    wild, sizes = wild_of(targets, pictures, eps)
    found = []
    for target, w, out, size, picture in zip(targets, wild, left_out, sizes, pictures, strict=True):
        for row, column in np.argwhere(w | out):
            off = picture[row, column] - target.image[row, column]
            worst = float(off[np.argmax(np.abs(off))])
            found.append(
                WildPixel(target.name, int(row), int(column), worst, float(size[row, column]), bool(out[row, column]))
            )
    return tuple(sorted(found, key=lambda pixel: -pixel.deviations))


def wild_note(found: Sequence[WildPixel], several: bool) -> tuple[str, ...]:
    """What to say of them."""
    if not found:
        return ()
    worst = ", ".join((f"{p.target} " if several else "") + f"row {p.row} column {p.column}" for p in found[:5])
    out = sum(p.left_out for p in found)
    done = "; they are left out" if out == len(found) else f"; {out} are left out" if out else ""
    many = f"{len(found)} pixels are" if len(found) > 1 else "1 pixel is"
    return (f"{many} further off than what the others show allows, the worst in {worst}{done}",)


def _range(picture: np.ndarray) -> np.ndarray:
    """By how much a picture varies over 3 x 3 pixels."""
    height, width = picture.shape[:2]
    padded = np.pad(picture, ((1, 1), (1, 1), (0, 0)), mode="edge")
    around = [padded[i : i + height, j : j + width] for i in range(3) for j in range(3)]
    return np.max(around, axis=0) - np.min(around, axis=0)
