"""Makes the map of `examples/room.toml`, a room with a window, a lamp and a door, and the picture of the guide.

Run from the top of the repository: python docs/make_room.py
"""

from pathlib import Path

import numpy as np

import diffwhitted

HEIGHT, SUBDIVIDED = 96, 6
HALF = np.array([3.0, 1.6, 2.5])
"""From the eye to the walls, floor and ceiling, metres."""


def seen(towards: np.ndarray) -> np.ndarray:
    """Linear RGB along directions (..., 3), from the middle of the room."""
    with np.errstate(divide="ignore"):
        axis = np.argmin(HALF / np.abs(towards), axis=-1)
    along = np.take_along_axis(np.abs(towards), axis[..., None], axis=-1) / HALF[axis][..., None]
    x, y, z = np.moveaxis(towards / along, -1, 0)
    shade = 0.75 + 0.25 * np.tanh(0.8 * (y + 0.4))
    wall = shade[..., None] * np.where((np.sin(9 * (x + z)) > 0.8)[..., None], (0.34, 0.3, 0.26), (0.42, 0.38, 0.33))
    boards = 0.8 + 0.2 * np.sin(14 * x) * (np.sin(3 * z) > -0.3)
    floor = boards[..., None] * np.array([0.22, 0.12, 0.06])
    colour = np.where((axis == 1)[..., None], np.where((y < 0)[..., None], floor, (0.6, 0.58, 0.55)), wall)
    # The window in the wall to the left, with its bars; the lamp on the ceiling; the door behind.
    window = (axis == 0) & (x < 0) & (np.abs(z + 0.4) < 0.9) & (np.abs(y - 0.25) < 0.75)
    bars = (np.abs((z + 0.4) % 0.6 - 0.3) > 0.265) | (np.abs(y - 0.25) < 0.04)
    sky = np.array([3.2, 4.0, 5.0]) * (0.7 + 0.4 * y[..., None])
    colour = np.where((window & ~bars)[..., None], sky, np.where(window[..., None], 0.25, colour))
    lamp = (axis == 1) & (y > 0) & ((x - 0.9) ** 2 + (z + 0.7) ** 2 < 0.35**2)
    colour = np.where(lamp[..., None], (14.0, 11.0, 7.5), colour)
    door = (axis == 2) & (z > 0) & (np.abs(x) < 0.5) & (y < 0.7)
    return np.where(door[..., None], (0.15, 0.05, 0.03), colour)


def panorama(height: int) -> np.ndarray:
    """The middle column looks along -z, the right towards +x; each texel is the mean over its part."""
    rows = SUBDIVIDED * height
    polar = (np.arange(rows) + 0.5)[:, None] * np.pi / rows
    azimuth = (np.arange(2 * rows) + 0.5) * np.pi / rows - np.pi
    across = np.sin(polar)
    towards = np.stack([across * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -across * np.cos(azimuth)], axis=-1)
    return seen(towards).reshape(height, SUBDIVIDED, 2 * height, SUBDIVIDED, 3).mean(axis=(1, 3))


if __name__ == "__main__":
    diffwhitted.write_image("examples/room.exr", panorama(HEIGHT).astype(np.float32), half=True)
    scene = diffwhitted.load_scene(Path("examples/room.toml"))
    camera = scene.cameras["main"].resized(640, 320)
    diffwhitted.write_image("docs/environment.jpg", np.asarray(diffwhitted.render(scene, camera)))
