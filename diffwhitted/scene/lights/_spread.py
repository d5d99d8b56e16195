"""Points spread evenly over what shines, the same ones every time."""

import numpy as np
from jaxtyping import Float

MOST_SAMPLES = 1024
"""Points of one light."""


def over_square(count: int) -> Float[np.ndarray, "n 2"]:
    """Points in the unit square: Hammersley's, each in the middle of its place; the middle for one. Stratified in rows
    and in columns, and for powers of 2 in all boxes between.
    """
    return np.stack([(np.arange(count) + 0.5) / count, _spread(count, 2)], axis=1)


def over_ball(count: int) -> Float[np.ndarray, "n 3"]:
    """Points in the unit ball, by Hammersley's in three dimensions, about its middle; the middle for one.

    In the ball, not on its surface: of a ball the share (3 - 2 t) t**2 lies on one side of a plane, t from 0 to 1 being
    the plane's way through it, which is what one ray makes of a straight edge.
    """
    u, v, w = (np.arange(count) + 0.5) / count, _spread(count, 2), _spread(count, 3)
    height, around = 1 - 2 * u, 2 * np.pi * v
    flat = np.sqrt(1 - height**2)
    points = np.stack([flat * np.cos(around), flat * np.sin(around), height], axis=1) * np.cbrt(w)[:, None]
    return points - points.mean(axis=0)


def _spread(count: int, base: int) -> Float[np.ndarray, "n"]:
    """The middles of `count` parts of 0 to 1 in van der Corput's order: digits reversed, behind the point."""
    rest, value, digit = np.arange(count), np.zeros(count), 1.0
    while rest.any():
        digit /= base
        value += digit * (rest % base)
        rest //= base
    return (np.argsort(np.argsort(value)) + 0.5) / count
