"""How noisy a target is: a number, a picture, or a model of read noise and gain."""

from dataclasses import dataclass

import numpy as np

from .._errors import FitError


@dataclass(frozen=True, eq=False)
class Noise:
    """Variance of a value = read^2 + gain * value, of linear values before the exposure is undone.

    `read`: standard deviation, (height, width, 3) or broadcast to it.
    """

    read: np.ndarray
    gain: float = 0.0

    def deviation(self, shown: np.ndarray) -> np.ndarray:
        """Standard deviations, (height, width, 3), of a picture that shows these values."""
        variance = self.read**2 + self.gain * np.maximum(shown, 0)
        least = np.min(variance[variance > 0], initial=np.inf)
        # Without read noise a pixel without light would be known for certain.
        return np.sqrt(np.broadcast_to(np.where(variance > 0, variance, least), shown.shape))


def checked_noise(noise, size: tuple[int, int], place: str) -> Noise | None:
    """The noise that a target states. Raises `FitError` for what is no noise."""
    if noise is None or isinstance(noise, Noise):
        return noise
    if isinstance(noise, tuple) and len(noise) == 2:
        read, gain = map(float, noise)
        if not (np.isfinite([read, gain]).all() and read >= 0 and gain >= 0 and read + gain > 0):
            raise FitError(f"{place}: noise = (read {read:g}, gain {gain:g}); allowed are two numbers >= 0, not both 0")
        return Noise(np.full((1, 1, 1), read), gain)
    noise = np.asarray(noise, np.float64)
    if noise.shape not in ((), size, (*size, 3)) or not np.all(np.isfinite(noise) & (noise > 0)):
        raise FitError(
            f"{place}: the noise must be a standard deviation > 0, one number or one a pixel; it has shape "
            f"{noise.shape} and goes down to {np.min(noise):g}"
        )
    return Noise(noise[..., None] if noise.ndim == 2 else np.broadcast_to(noise, (*size, 3)))
