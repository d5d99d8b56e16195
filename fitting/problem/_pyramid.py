"""Coarse to fine: where rays move, a fit looks at blurred residuals first.

The loss of a refractive index has local minima wherever edges of the picture and of the target fall together by
chance. Blur residual and Jacobian alike, and the edges find each other from further away. The last level is
sharp, and what a fit reports is that of the sharp picture.
"""

import numpy as np

BROADEST = 2 / 15
"""Standard deviation of the first blur, in the shorter side of the picture."""
STEP = 4
"""Each level blurs so many times less than the one before, until a pixel is hardly blurred."""


def blurs(width: int, height: int) -> tuple[float, ...]:
    """Standard deviations in pixels, from coarse to 0."""
    levels, sigma = [], BROADEST * min(width, height)
    while sigma >= 1:
        levels.append(sigma)
        sigma /= STEP
    return (*levels, 0.0)


def blurred(rows: np.ndarray, sigma: float) -> np.ndarray:
    """Pictures (..., height, width) blurred by a Gaussian and sampled once every sigma pixels.

    Beyond the border there is nothing: weights are those of the pixels that are there.
    """
    down, across = (_kernel(count, sigma).astype(rows.dtype) for count in rows.shape[-2:])
    return down @ rows @ across.T


def _kernel(count: int, sigma: float) -> np.ndarray:
    """(samples, count), each row the normalised weights of one sample."""
    samples = max(1, round(count / sigma))
    middles = (np.arange(samples) + 0.5) * count / samples
    weights = np.exp(-0.5 * ((np.arange(count) + 0.5 - middles[:, None]) / sigma) ** 2)
    return weights / weights.sum(axis=1, keepdims=True)
