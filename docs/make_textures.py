"""Makes the pictures that `examples/globe.toml` lays on its objects: a globe and boards of wood, from sums of waves.

Run from the top of the repository: python docs/make_textures.py
"""

import numpy as np

import diffwhitted

random = np.random.default_rng(14)


def waves(points, count: int, longest: float) -> np.ndarray:
    """A sum of waves over points (..., n), each in a direction of its own, shorter ones lower."""
    total = np.zeros(points.shape[:-1])
    for _ in range(count):
        direction = random.normal(size=points.shape[-1])
        length = longest * random.uniform(0.15, 1)
        total += length * np.sin(
            2 * np.pi * points @ direction / (np.linalg.norm(direction) * length) + random.uniform(0, 7)
        )
    return total / longest


def globe(height: int = 128) -> np.ndarray:
    """Land, sea, ice at the poles, and every thirtieth degree."""
    latitude = np.pi * (0.5 - (np.arange(height) + 0.5) / height)[:, None]
    longitude = 2 * np.pi * (np.arange(2 * height) + 0.5)[None] / (2 * height)
    x, y, z = np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)
    points = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
    level = waves(points, 24, 1.6)[..., None]
    land = np.where(level > 1.1, (0.35, 0.22, 0.1), (0.08, 0.3, 0.07))
    colour = np.where(level > 0.25, land, np.where(level > 0, (0.1, 0.3, 0.5), (0.02, 0.08, 0.3)))
    colour = np.where(np.abs(latitude)[..., None] > 1.25 + 0.1 * level, 0.85, colour)
    lines = [abs((np.rad2deg(angle) + 15) % 30 - 15) < 1.0 for angle in np.broadcast_arrays(latitude, longitude)]
    return np.where((lines[0] | lines[1])[..., None], 0.6 * colour + 0.2, colour)


def boards(size: int = 128) -> np.ndarray:
    """Four boards with their grain along the columns."""
    row, column = np.mgrid[:size, :size] / size
    board = np.floor(4 * column)
    shade = random.uniform(0.7, 1.1, 4)[board.astype(int)]
    bend = waves(np.stack([row, column], axis=-1), 6, 1.0)
    grain = 0.5 + 0.5 * np.sin(60 * column + 4 * bend + 17 * board)
    gap = np.where(4 * column % 1 < 0.04, 0.35, 1)
    return (shade * gap * (0.7 + 0.3 * grain))[..., None] * np.array([0.42, 0.24, 0.11])


diffwhitted.write_image("examples/globe.jpg", globe().astype(np.float32))
diffwhitted.write_image("examples/boards.jpg", boards().astype(np.float32))
