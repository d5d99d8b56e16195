"""Mount: four balls of glass before a fractal mountain."""

from math import log, sqrt

import numpy as np

from ..scene import Mesh, SphereSet
from ._parts import TETRAHEDRAL, THREE_AROUND, Parts, Z, paint, turned, usual_camera, usual_scene

DIMENSION = 2.2
ROUGHNESS = sqrt((2 / 2 ** (1 / (DIMENSION - 1))) ** 2 - 1)
"""Standard deviation of a middle's offset, in halves of the side that it divides."""
RADIUS, MIDDLE = 0.17, (-0.8, 0.8, 1.0)
SEED, STEPS = 21, 134456
"""Of the generator of random numbers."""


def mount(size: int) -> Parts:
    """A height field of 2 * 4^size triangles, and four balls that touch each other."""
    glass = paint((1, 1, 1), 0.1, 0.1, 6.7, k_h=0.4, k_t=0.9, refractive_index=1.5)
    return usual_scene(
        [Mesh("mountain", *as_mesh(heights(size)), "rock"), SphereSet("balls", ball_centres(), RADIUS, "glass")],
        {"rock": paint((0.5, 0.45, 0.35), 1.0), "glass": glass},
        [(-100, -100, 100)],
        usual_camera((-1.6, 1.6, 1.7), (0, 0, 0)),
    )


def ball_centres() -> np.ndarray:
    """(4, 3): a tetrahedron whose sides are two radii."""
    up = RADIUS * sqrt(1.5) * Z
    tilted = up @ turned((1, 1, 0), TETRAHEDRAL)
    return MIDDLE + np.stack([up, *(tilted @ turned(Z, angle) for angle in THREE_AROUND)])


def heights(size: int) -> np.ndarray:
    """Heights (n, n) over [-1, 1]^2, n = 2^size + 1, by division of squares; x along the first axis.

    The middle of a side lies `ROUGHNESS` times half the side times a normal number off the mean of its ends, that of a
    square sqrt(2) times as far off the mean of its corners. The corners of the whole are at height 0.
    """
    count = 2**size
    height = np.zeros((count + 1, count + 1))
    for level in range(size):
        # Divide the sides along x, those along y, then the squares.
        step, half = count >> level, count >> (level + 1)
        offset = ROUGHNESS * 2 / count * half
        ends, middles = range(0, count + 1, step), range(half, count, step)
        for i in middles:
            for j in ends:
                height[i, j] = (height[i - half, j] + height[i + half, j]) / 2 + offset * normal_number(i, j)
                height[j, i] = (height[j, i - half] + height[j, i + half]) / 2 + offset * normal_number(j, i)
        for i in middles:
            for j in middles:
                corners = height[i - half : i + half + 1 : step, j - half : j + half + 1 : step]
                height[i, j] = corners.mean() + sqrt(2) * offset * normal_number(i, j)
    return height


def normal_number(i: int, j: int) -> float:
    """A number of a normal distribution for a point of the grid, by the polar method."""
    state = SEED + ((i << 17) + (j << 9) + (i << 1)) % 2**16
    square = 0.0
    while not 0 < square < 1:
        state = _next(state)
        first = 2 * state / STEPS - 1
        state = _next(state)
        square = first**2 + (2 * state / STEPS - 1) ** 2
    return first * sqrt(-2 * log(square) / square)


def _next(state: int) -> int:
    return (8121 * state + 28411) % STEPS


def as_mesh(height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n^2, 3) and faces (2 (n - 1)^2, 3), which face upwards."""
    count = len(height)
    x, y = np.meshgrid(np.linspace(-1, 1, count), np.linspace(-1, 1, count), indexing="ij")
    first = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    corners = first, first + count, first + count + 1, first + 1
    faces = np.concatenate([np.stack([corners[k] for k in three], axis=-1) for three in ((0, 1, 2), (0, 2, 3))])
    return np.stack([x, y, height], axis=-1).reshape(-1, 3), faces
