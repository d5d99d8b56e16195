"""Ordered dither, random dither and halftones: a picture on few levels, each pixel by itself.

Hearn and Baker, Computer Graphics, C version, 2nd edition (1997), section 14-4, equations (14-30) to (14-35).
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .._errors import InputError
from ._levels import checked

D_2 = np.asarray([[3, 1], [0, 2]])
"""(14-31)."""
D_3 = np.asarray([[7, 2, 6], [4, 0, 1], [3, 8, 5]])
"""(14-32); one more in each place is the mask (14-30)."""
LARGEST_SIZE = 256


def dither_matrix(size: int) -> np.ndarray:
    """D_n (n, n) of the numbers 0 to n^2 - 1: D_2, D_3, and from these (14-34)

        D_n = [4 D_(n/2) + D_2(1,1)   4 D_(n/2) + D_2(1,2)]
              [4 D_(n/2) + D_2(2,1)   4 D_(n/2) + D_2(2,2)].

    Raises `InputError` unless the size is 2 or 3 times a power of 2, to 256.
    """
    found = {2: D_2, 3: D_3}.get(size)
    if found is None:
        whole = isinstance(size, (int, np.integer)) and not isinstance(size, bool)
        if not whole or not 4 <= size <= LARGEST_SIZE or size % 2:
            raise InputError(
                f"size = {size!r} of a dither matrix; allowed is 2, 3, 4, 6, 8, 12, 16, ... {LARGEST_SIZE}"
            )
        half = 4 * dither_matrix(int(size) // 2)
        found = np.block([[half + D_2[0, 0], half + D_2[0, 1]], [half + D_2[1, 0], half + D_2[1, 1]]])
    return found


def ordered_dither(image: Any, size: int = 4, levels: int = 2) -> Any:
    """Each pixel on the level below or above its value, by its place: on where I n^2 > D_n(row mod n, column mod n),
    after (14-33).

    image: (height, width) or (height, width, 3) of linear light in [0, 1]. size: n, see `dither_matrix`. With L
    `levels` the same is done with the fraction of (L - 1) I, which lies between two of them. Returns what is shown, of
    the same shape, in [0, 1]: the mean of a plain area is I to 1 / (n^2 (L - 1)). The derivative is 0.
    Raises `InputError`.
    """
    image = checked(image, levels, "ordered_dither")
    matrix = dither_matrix(size)
    rows, columns = (jnp.arange(side) % size for side in image.shape[:2])
    limits = jnp.asarray(matrix)[rows[:, None], columns]
    limits = limits if image.ndim == 2 else limits[..., None]
    scaled = image * (levels - 1)
    below = jnp.minimum(jnp.floor(scaled), levels - 2)
    return (below + ((scaled - below) * size**2 > limits)) / (levels - 1)


def random_dither(image: Any, key: Any, levels: int = 2) -> Any:
    """Dither noise: floor((L - 1) I + u) / (L - 1) with u evenly distributed in [0, 1), so that the mean is I.

    image: as in `ordered_dither`. key: of JAX's random numbers, `jax.random.key(0)`; the channels draw apart.
    Raises `InputError`.
    """
    image = checked(image, levels, "random_dither")
    noise = jax.random.uniform(key, image.shape, image.dtype)
    return jnp.minimum(jnp.floor(image * (levels - 1) + noise), levels - 1) / (levels - 1)


def halftone(image: Any, size: Any = 3, levels: int = 2) -> Any:
    """Each pixel as a pattern of n x n: at the intensity I the one of the number k = min(floor(I (n^2 + 1)), n^2), in
    which the positions of the mask up to k are on.

    image: as in `ordered_dither`. size: n, whose mask is D_n + 1, (14-30) for n = 3; or a mask (n, n) of the numbers 1
    to n^2; or patterns (k, n, n) in [0, 1], which need not add to each other, and then k = min(floor(I k), k - 1).
    With L `levels` there are n^2 (L - 1) + 1 patterns: each turn around the mask adds a level. Returns (n height, n
    width) or (n height, n width, 3). Raises `InputError`.
    """
    image = checked(image, levels, "halftone")
    patterns = _patterns(size, levels)
    count = len(patterns)
    chosen = jnp.minimum(jnp.floor(image * count), count - 1).astype(jnp.int32)
    shown = jnp.asarray(patterns, image.dtype)[chosen]
    # Let the rows and columns of a pattern follow those of the picture.
    shown = jnp.moveaxis(shown, (-2, -1), (1, 3)) if image.ndim == 2 else jnp.moveaxis(shown, (3, 4), (1, 3))
    height, rows, width, columns = shown.shape[:4]
    return shown.reshape(height * rows, width * columns, *image.shape[2:])


def _patterns(size: Any, levels: int) -> np.ndarray:
    """All patterns from the darkest on, (k, n, n)."""
    if np.ndim(size) == 3:
        patterns = np.asarray(size, float)
        if patterns.shape[1] != patterns.shape[2] or len(patterns) < 2 or levels != 2:
            raise InputError(f"halftone: patterns of shape {patterns.shape}; allowed is (k, n, n) with levels = 2")
        if not ((patterns >= 0) & (patterns <= 1)).all():
            raise InputError("halftone: a pattern has a value outside of [0, 1]")
        return patterns
    mask = np.asarray(size) if np.ndim(size) == 2 else dither_matrix(size) + 1
    n = len(mask)
    if mask.shape != (n, n) or not np.array_equal(np.sort(mask, axis=None), np.arange(1, n * n + 1)):
        raise InputError(
            f"halftone: a mask of shape {mask.shape}; allowed is (n, n) of the numbers 1 to n^2, each once"
        )
    numbers = np.arange(n * n * (levels - 1) + 1)[:, None, None]
    return (numbers // n**2 + (mask <= numbers % n**2)) / (levels - 1)
