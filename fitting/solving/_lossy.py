"""Targets that a JPEG lost something of: what it loses is the same for pictures that look the same.

A codec takes colour together over several pixels and rounds waves over 8 x 8 of them. Both leave errors that go along
with the picture, above all at edges, and are no noise. But the codec C is known. Of pictures that are nearly the fitted
one, by coefficients that are a little other and with the noise that a picture had before it was written,

    loss = C(picture) - picture

has a mean, such as colour that runs over an edge, and a scatter, the rounding. The mean is taken from the target, anew
from each solution; the scatter says by example how far off the coefficients may be.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from diffwhitted.image import decode_signal, encode_signal

from ..judging._normal import normal_inverse
from ..problem._problem import Problem
from ..problem._target import CheckedTarget
from ..problem._whole_pictures import whole_rows

DRAWS = 16
SEED = 1992
ROUNDS = 4
"""The target follows the solution, which follows the target."""
LARGEST = 255
MOST_PIXELS = 1_000_000
"""In all targets; of more the examples would not fit the memory."""
OTHER = 2.0
"""Codes, RMS, by which the pictures of the examples are other than the fitted one: so that waves are rounded another
way.
"""


class Examples(NamedTuple):
    """What a target may have lost, (draws, height, width, 3): in codes, and in linear light."""

    codes: Float[np.ndarray, "draws height width 3"]
    light: Float[np.ndarray, "draws height width 3"]

    @property
    def departures(self) -> Float[np.ndarray, "draws height width 3"]:
        """In linear light, about their mean."""
        spare = len(self.light) / max(len(self.light) - 1, 1)
        apart = (self.light - self.light.mean(axis=0)) * spare**0.5
        return np.broadcast_to(apart, (DRAWS, *apart.shape[1:]))


def is_known(targets: Sequence[CheckedTarget]) -> bool:
    """Can the losses of all targets be repeated?"""
    few = sum(t.mask.size for t in targets) <= MOST_PIXELS
    return few and all(t.file is not None and t.file.jpeg is not None and not t.monochrome for t in targets)


@dataclass(frozen=True)
class Codec:
    """Of the targets, with noise of so many codes before they were written."""

    targets: tuple[CheckedTarget, ...]
    sigma: float = 0.0

    def examples(self, problem: Problem, values: np.ndarray) -> list[Examples]:
        """Of each target, near what it shows at these coefficients."""
        looks = list(whole_rows(problem, values))
        count, random = len(problem.unknowns), np.random.default_rng(SEED)
        jacobians = [problem.joined(np.moveaxis(r.columns, 2, 0).astype(np.float64), r.numbers) for r in looks]
        gram = sum(np.einsum("phwc,qhwc->pq", j, j) for j in jacobians)
        # Steps that change the pictures, as the fit weighs them, by as much in all ways.
        length, ways = np.linalg.eigh(normal_inverse(np.asarray(gram), 1e-9))
        steps = random.normal(size=(DRAWS, count)) @ (ways * np.sqrt(np.maximum(length, 0))).T
        changes = []
        for look, jacobian in zip(looks, jacobians, strict=True):
            weight = np.asarray(look.view.weight, np.float64)
            slope = np.divide(jacobian, weight, out=np.zeros_like(jacobian), where=weight > 0)
            changes.append(np.tensordot(steps, slope, 1).astype(np.float32))
        pairs = list(zip(self.targets, looks, changes, strict=True))
        moved = [(encoded(t, look.shown + c) - encoded(t, look.shown))[:, t.mask > 0] for t, look, c in pairs]
        size = max(float(np.sqrt(np.mean(np.concatenate([m.ravel() for m in moved]) ** 2))), 1e-9)
        return [self._of(t, look.shown, c * OTHER / size, random) for t, look, c in pairs]

    def _of(self, target: CheckedTarget, shown: np.ndarray, changes: np.ndarray, random) -> Examples:
        assert target.file is not None and target.file.jpeg is not None, "asked for by `is_known`"
        used = target.mask[..., None] > 0
        if not used.any():
            return Examples(np.zeros((1, *shown.shape)), np.zeros((1, *shown.shape)))
        codes, light = [], []
        for change in changes:
            # Pixels that do not count hold what the file has of them.
            picture = np.clip(shown + change, 0, 1)
            signal = np.where(used, encoded(target, picture), encoded(target, target.file.pixels))
            noisy = np.rint(np.clip(signal + self.sigma * random.normal(size=signal.shape), 0, LARGEST))
            read = target.file.jpeg.of(noisy.astype(np.uint8)).astype(np.float64)
            codes.append((read - signal).astype(np.float32))
            light.append((decoded(target, read) - picture).astype(np.float32))
        return Examples(np.stack(codes), np.stack(light))

    def corrected(self, examples: Sequence[Examples]) -> tuple[CheckedTarget, ...]:
        """The targets without what they have lost on average."""
        return tuple(
            replace(
                t, image=np.where(t.mask[..., None] > 0, t.image - e.light.mean(axis=0), t.image).astype(t.image.dtype)
            )
            for t, e in zip(self.targets, examples, strict=True)
        )

    def as_noisy(self, shown: Sequence[np.ndarray], examples: Sequence[Examples]) -> "Codec":
        """With as much noise as makes the examples scatter by what is left over."""
        left, scatter = [], []
        for t, picture, found in zip(self.targets, shown, examples, strict=True):
            used, mean = t.mask > 0, found.codes.mean(axis=0)
            left.append((encoded(t, t.image) - encoded(t, picture) - mean)[used].ravel())
            scatter.append((found.codes - mean)[:, used].ravel())
        excess = _middle(np.concatenate(left)) - DRAWS / (DRAWS - 1) * _middle(np.concatenate(scatter))
        return replace(self, sigma=max(self.sigma**2 + excess, 0.0) ** 0.5)


def encoded(target: CheckedTarget, picture: np.ndarray) -> np.ndarray:
    """Codes, not rounded."""
    assert target.file is not None
    return LARGEST * encode_signal(np.clip(picture.astype(np.float64), 0, 1), target.file.encoding or "srgb")


def decoded(target: CheckedTarget, codes: np.ndarray) -> np.ndarray:
    assert target.file is not None
    return decode_signal(codes / LARGEST, target.file.encoding or "srgb")


def _middle(values: np.ndarray) -> float:
    """The mean square of all but the largest hundredth."""
    square = np.sort(values**2)
    return float(square[: max(int(0.99 * square.size), 1)].mean())
