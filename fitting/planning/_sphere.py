"""Directions all around, and the best of them by a search from the best of a few."""

from collections.abc import Callable

import numpy as np

FINEST = 0.02
"""Radians: the search ends where a step of this size gains nothing."""


def all_around(count: int) -> np.ndarray:
    """Unit vectors (count, 3), evenly spread: Fibonacci's lattice on the sphere, its poles on the y axis."""
    number = np.arange(count)
    height = 1 - (2 * number + 1) / count
    angle = np.pi * (3 - np.sqrt(5)) * number
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.cos(angle), height, ring * np.sin(angle)], axis=1)


def best_direction(score: Callable, directions: np.ndarray, at_try: Callable[[int], None]) -> np.ndarray:
    """The unit vector with the highest score: the best of these, then a pattern search in its tangent plane, whose
    steps halve where none of the four neighbours is better.

    `score(direction)`: anything that can be compared; `at_try`: told the number of each try, from 1.
    """
    tried = 0

    def scored(direction):
        nonlocal tried
        tried += 1
        at_try(tried)
        return score(direction)

    best, direction = max(((scored(d), d) for d in directions), key=lambda pair: pair[0])
    step = (4 * np.pi / max(len(directions), 4)) ** 0.5 / 2
    while step > FINEST:
        across = np.cross(direction, np.eye(3)[np.argmin(abs(direction))])
        across /= np.linalg.norm(across)
        ways = np.stack([across, np.cross(direction, across)])
        near = [_unit(direction + step * way) for way in (*ways, *-ways)]
        found, neighbour = max(((scored(d), d) for d in near), key=lambda pair: pair[0])
        if found > best:
            best, direction = found, neighbour
        else:
            step /= 2
    return direction


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)
