"""Targets that a JPEG lost something of: what it loses is the same for pictures that look the same.

A codec takes colour together over several pixels and rounds waves over 8 x 8 of them. Both leave errors that go along
with the picture, above all at edges, and are no noise. But the codec is known: what it makes of the fitted picture is
what it would make of the true one, nearly, so residuals are taken from there. With C the codec,

    residual = target - C(model) = (target - (C(model) - model)) - model,

so a fit to the target in brackets, anew from each solution, ends where C(model) leaves least. Noise that a picture had
before it was written decides how its waves were rounded; then C is the mean over draws of such noise, as large as what
is left over says.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from diffwhitted.image import decode_signal, encode_signal

from ..problem._target import CheckedTarget

DRAWS = 16
SEED = 1992
ROUNDS = 4
"""The target follows the solution, which follows the target."""
LARGEST = 255
LEAST_NOISE = 0.5
"""Codes, standard deviation. Without any noise what a codec leaves jumps with the picture, and is no guide."""


def is_known(targets: Sequence[CheckedTarget]) -> bool:
    """Can the losses of all targets be repeated?"""
    return all(t.file is not None and t.file.jpeg is not None and not t.monochrome for t in targets)


@dataclass(frozen=True)
class Codec:
    """Of the targets, with noise of so many codes before they were written."""

    targets: tuple[CheckedTarget, ...]
    sigma: float

    def draws(self, shown: Sequence[np.ndarray]) -> list[np.ndarray]:
        """For each target the codes that are read of what is shown, (draws, height, width, 3), with other noise each
        time.
        """
        return [self._drawn(t, p) for t, p in zip(self.targets, shown, strict=True)]

    def _drawn(self, target: CheckedTarget, picture: Float[np.ndarray, "height width 3"]) -> np.ndarray:
        assert target.file is not None and target.file.jpeg is not None, "asked for by `is_known`"
        signal, random = encoded(target, picture), np.random.default_rng(SEED)
        # Pixels that do not count hold what the file has of them; a target without others needs no draw.
        used = target.mask > 0
        if not used.any():
            return signal[None]
        signal = np.where(used[..., None], signal, encoded(target, target.file.pixels))
        found = []
        for _ in range(DRAWS):
            noisy = np.rint(np.clip(signal + self.sigma * random.normal(size=signal.shape), 0, LARGEST))
            found.append(target.file.jpeg.of(noisy.astype(np.uint8)))
        return np.stack(found)

    def corrected(self, shown: Sequence[np.ndarray], draws: Sequence[np.ndarray]) -> tuple[CheckedTarget, ...]:
        """The targets without what the codec does to pictures (height, width, 3) that are shown, linear."""
        found = []
        for target, picture, codes in zip(self.targets, shown, draws, strict=True):
            lost = decoded(target, codes).mean(axis=0) - picture
            image = np.where(target.mask[..., None] > 0, target.image - lost, target.image)
            found.append(replace(target, image=image.astype(target.image.dtype)))
        return tuple(found)

    def as_noisy(self, draws: Sequence[np.ndarray]) -> "Codec":
        """With as much noise as what is left over tells."""
        left, noise = self.apart(draws)
        return replace(self, sigma=max(self.sigma * float(np.clip(left / max(noise, 1e-9), 0.5, 2)), LEAST_NOISE))

    def departures(self, shown: Sequence[np.ndarray]) -> list[np.ndarray]:
        """For each target what the draws are apart from their mean, linear, (draws, height, width, 3)."""
        found = []
        for target, codes in zip(self.targets, self.draws(shown), strict=True):
            light = decoded(target, codes)
            apart = (light - light.mean(axis=0)) * (DRAWS / (DRAWS - 1)) ** 0.5
            found.append(np.broadcast_to(apart, (DRAWS, *apart.shape[1:])))
        return found

    def apart(self, draws: Sequence[np.ndarray]) -> tuple[float, float]:
        """RMS in codes of what is left over, and of what noise so large would leave over."""
        left, noise = [], []
        for target, codes in zip(self.targets, draws, strict=True):
            mean, used = codes.mean(axis=0), target.mask > 0
            left.append((encoded(target, target.image) - mean)[used].ravel())
            noise.append((codes - mean)[:, used].ravel())
        spare = DRAWS / (DRAWS - 1)
        return _middle(np.concatenate(left)), spare**0.5 * _middle(np.concatenate(noise))


def encoded(target: CheckedTarget, picture: np.ndarray) -> np.ndarray:
    assert target.file is not None
    return LARGEST * encode_signal(np.clip(picture.astype(np.float64), 0, 1), target.file.encoding or "srgb")


def decoded(target: CheckedTarget, codes: np.ndarray) -> np.ndarray:
    assert target.file is not None
    return decode_signal(codes / LARGEST, target.file.encoding or "srgb")


def _middle(values: np.ndarray) -> float:
    """Root of the mean square of all but the largest hundredth."""
    square = np.sort((values**2).ravel())
    return float(np.sqrt(square[: max(int(0.99 * square.size), 1)].mean()))
