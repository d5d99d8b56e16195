"""What the residual of each pixel is made of: the same noise everywhere, noise of light, and what samples leave out.

The variance of a residual is a sum of known shapes with unknown sizes,

    sigma^2 = theta_0 + theta_1 * value + theta_2 * spread,

where `value` is what the picture shows (Poisson) and `spread` how much the samples within a pixel vary beyond a smooth
course (edges, of which n x n points know the area only nearly). The sizes maximise the likelihood of the
residuals, by an update that keeps them positive and never lowers it (MM for variance components: Zhou, Hu, Zhou and
Lange 2019, equation 8):

    theta_k <- theta_k sqrt(sum x_k r^2 / sigma^4 / sum x_k / sigma^2).
"""

from dataclasses import dataclass

import numpy as np

STEPS = 60
LARGEST_SAMPLE = 60_000
"""More residuals than these say nothing more of a few sizes."""
CLEARLY = 12.0
"""A shape counts where it raises the log-likelihood by so much: by chance, once in a million pictures."""
WILD = 6.0
"""Residuals beyond so many standard deviations say nothing of the others' variance."""


@dataclass(frozen=True)
class Variance:
    """The sizes of the shapes, by name."""

    sizes: dict[str, float]

    def of(self, shapes: dict[str, np.ndarray]) -> np.ndarray:
        """sigma^2, where these are the shapes."""
        return np.sum([size * shapes[name] for name, size in self.sizes.items()], axis=0)

    @property
    def is_even(self) -> bool:
        """Is it the same everywhere?"""
        return set(self.sizes) == {"even"}


def variance_of(residual: np.ndarray, shapes: dict[str, np.ndarray], floor: float) -> Variance:
    """The sizes that the residuals (n,) ask for, from those shapes (n,) that they ask for clearly.

    `shapes`: "even" (ones), then others in the order in which they are tried. `floor`: least value of sigma^2, of
    the arithmetic.
    """
    step = max(1, len(residual) // LARGEST_SAMPLE)
    square = residual[::step].astype(np.float64) ** 2
    mine = {name: np.asarray(shape[::step], np.float64) for name, shape in shapes.items()}
    chosen, best = ["even"], None
    for name in list(mine):
        trial = list(dict.fromkeys([*chosen, name]))
        sizes, gain = _fitted(square, [mine[k] for k in trial], floor)
        if best is None or gain > best[1] + CLEARLY:
            chosen, best = trial, (sizes, gain)
    assert best is not None
    return Variance(dict(zip(chosen, best[0], strict=True)))


def _fitted(square: np.ndarray, shapes: list[np.ndarray], floor: float) -> tuple[list[float], float]:
    """The sizes, and twice the log-likelihood without its constant, halved."""
    stack = np.stack(shapes)
    middle = max(float(np.median(square)) / 0.455, 1e-300)
    sizes = np.array([middle / len(shapes) / max(float(shape.mean()), 1e-300) for shape in stack])
    for _ in range(STEPS):
        total = sizes @ stack + floor
        within = np.minimum(square, WILD**2 * total)
        upper, lower = stack @ (within / total**2), stack @ (1 / total)
        sizes = sizes * np.sqrt(np.divide(upper, lower, out=np.ones_like(upper), where=lower > 0))
    total = sizes @ stack + floor
    within = np.minimum(square, WILD**2 * total)
    return sizes.tolist(), -0.5 * float(np.sum(np.log(total) + within / total))
