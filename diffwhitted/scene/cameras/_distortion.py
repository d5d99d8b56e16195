"""What a lens of glass bends: the distortion of Brown and Conrady as OpenCV has it, and its inverse.

    x' = x (1 + k1 r2 + k2 r2^2) + 2 p1 x y + p2 (r2 + 2 x^2)
    y' = y (1 + k1 r2 + k2 r2^2) + p1 (r2 + 2 y^2) + 2 p2 x y,      r2 = x^2 + y^2

with (x, y) the undistorted place at z = 1, x to the right and y down (OpenCV, Camera Calibration and 3D
Reconstruction, "Detailed Description"; Brown 1966). A ray through a pixel needs the inverse, which Newton's method
finds; its derivatives are those of the implicit function theorem.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._errors import SceneError
from ...records import Row, listed

DISTORTION = Row(
    "distortion", "numbers", "k1, k2, p1, p2 of OpenCV's distortion, on (x, y) at z = 1 with y down.", default=None,
    scale="unbounded", fit_bounds=(-0.5, 0.5), moves="rays", parts=("k1", "k2", "p1", "p2"),
    source="Brown 1966; OpenCV, Camera Calibration",
)  # fmt: skip
STEPS = 12
"""Of Newton's method."""
LONGEST_STEP = 0.5
LEAST_DETERMINANT = 1e-4
"""Below it the picture folds over itself, and steps and derivatives are 0."""
CLOSE = 1e-6
"""So well, at z = 1, must the inverse be met."""
SAMPLES = 17
"""Along a side of the picture, and along the way from the principal point to each, where the inverse is looked at."""


def distorted(k, x, y):
    """(x', y') of the formula above; of JAX's arrays and NumPy's."""
    squared = x * x + y * y
    radial = 1 + squared * (k[0] + k[1] * squared)
    return (
        x * radial + 2 * k[2] * x * y + k[3] * (squared + 2 * x * x),
        y * radial + k[2] * (squared + 2 * y * y) + 2 * k[3] * x * y,
    )


def _slopes(k, x, y):
    """dx'/dx, dx'/dy (which is dy'/dx), dy'/dy."""
    squared = x * x + y * y
    radial, bend = 1 + squared * (k[0] + k[1] * squared), 2 * k[0] + 4 * k[1] * squared
    return (
        radial + bend * x * x + 2 * k[2] * y + 6 * k[3] * x,
        bend * x * y + 2 * k[2] * x + 2 * k[3] * y,
        radial + bend * y * y + 6 * k[2] * y + 2 * k[3] * x,
    )


def _solved(k, x, y, u, v, xp):
    """What moves (x', y') at (x, y) by (u, v), to first order; 0 where the picture folds. `xp`: jnp or np."""
    xx, xy, yy = _slopes(k, x, y)
    determinant = xx * yy - xy * xy
    open_ = determinant > LEAST_DETERMINANT
    part = xp.where(open_, 1 / xp.where(open_, determinant, 1), 0)
    return (yy * u - xy * v) * part, (xx * v - xy * u) * part


def _newton(k, at, aim, xp):
    """One step of Newton's method from a place towards what is distorted to `aim`."""
    x, y = at
    bent = distorted(k, x, y)
    across, down = _solved(k, x, y, aim[0] - bent[0], aim[1] - bent[1], xp)
    return x + xp.clip(across, -LONGEST_STEP, LONGEST_STEP), y + xp.clip(down, -LONGEST_STEP, LONGEST_STEP)


@jax.custom_jvp
def undistorted(
    k: Float[Array, "4"], x: Float[Array, "*n"], y: Float[Array, "*n"]
) -> tuple[Float[Array, "*n"], Float[Array, "*n"]]:
    """The place at z = 1 that is distorted to (x, y); differentiable in all three, to any order.

    Finite everywhere. Where there is no inverse, the value is where Newton's method stopped and derivatives are 0.
    """
    return jax.lax.fori_loop(0, STEPS, lambda _, at: _newton(k, at, (x, y), jnp), (x, y))


@undistorted.defjvp
def _undistorted_jvp(primals, tangents):
    """D(u; k) = x, so D_u du = dx - D_k dk."""
    k, x, y = primals
    at = undistorted(k, x, y)
    _, (by_k_x, by_k_y) = jax.jvp(lambda k: distorted(k, *at), (k,), (tangents[0],))
    return at, _solved(k, *at, tangents[1] - by_k_x, tangents[2] - by_k_y, jnp)


def check_inverse(distortion, flat: Callable, width, height, crop, place: str) -> None:
    """Raise `SceneError` unless every pixel of the picture has one undistorted place.

    `flat`: places at z = 1 of columns and rows of the full picture. The way from the principal point to each sample of
    the border must be free of folds, and so is all that lies between.
    """
    k = np.asarray(distortion, np.float64)
    left, top = crop[:2] if crop else (0, 0)
    share = np.linspace(0, 1, SAMPLES)
    column = left + width * np.concatenate([share, share, 0 * share, 0 * share + 1])
    row = top + height * np.concatenate([0 * share, 0 * share + 1, share, share])
    aim = tuple(np.asarray(side, np.float64) for side in flat(jnp.asarray(column), jnp.asarray(row)))
    at = aim
    for _ in range(STEPS):
        at = _newton(k, at, aim, np)
    reached = distorted(k, *at)
    missed = np.hypot(reached[0] - aim[0], reached[1] - aim[1]) > CLOSE * (1 + np.hypot(*aim))
    xx, xy, yy = _slopes(k, at[0] * share[:, None], at[1] * share[:, None])
    folded = missed | ((xx * yy - xy * xy).min(axis=0) < LEAST_DETERMINANT)
    if folded.any():
        worst = int(np.argmax(np.where(folded, np.hypot(*aim), -1)))
        raise SceneError(
            f"{place}: distortion = {listed(distortion)} has no inverse at column {column[worst]:g}, row "
            f"{row[worst]:g} of the picture; allowed is one that bends every pixel from one direction. Look at the "
            "order k1, k2, p1, p2 and at focal, or crop the picture to what the lens was measured in"
        )
