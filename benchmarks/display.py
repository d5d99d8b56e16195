"""Displays of few levels: how long each method takes, how near its mean is, and where its noise lies.

Low frequencies are what an eye sees from afar: the part of a method's error, of plain areas, below an eighth of a cycle
a pixel, as a share of all its error.
"""

import time
from collections.abc import Callable

import jax
import numpy as np

from diffwhitted import display

from ._figures import Figure
from ._fresh import run

WIDTH, HEIGHT, TIMES = 640, 480, 15
AT_MOST_MS = {"error diffusion": 50.0, "error diffusion, serpentine": 1000.0}
SIDE, GREYS = 256, 31
LOW = 1 / 8
METHODS: dict[str, Callable] = {
    "ordered, 4 x 4": lambda image: display.ordered_dither(image, 4),
    "ordered, 8 x 8": lambda image: display.ordered_dither(image, 8),
    "halftone, 3 x 3": lambda image: display.halftone(image, 3),
    "error diffusion": display.error_diffusion,
    "error diffusion, serpentine": lambda image: display.error_diffusion(image, serpentine=True),
    "dot diffusion": display.dot_diffusion,
    "random": lambda image: display.random_dither(image, jax.random.key(0)),
}


def measure() -> list[Figure]:
    ramp = np.tile(np.linspace(0, 1, WIDTH, dtype=np.float32), (HEIGHT, 1))
    figures = []
    for name, method in METHODS.items():
        seconds = []
        for _ in range(TIMES + 1):
            begun = time.perf_counter()
            jax.block_until_ready(method(ramp))
            seconds.append(time.perf_counter() - begun)
        note = f"shortest {min(seconds[1:]) * 1e3:.1f} ms; {WIDTH} x {HEIGHT} of one channel"
        figures.append(Figure(f"{name}: time", float(np.median(seconds[1:])) * 1e3, "ms", AT_MOST_MS.get(name), note))
        error, low = _means_and_spectrum(method)
        figures.append(Figure(f"{name}: largest error of the mean of a plain area", error, "", None))
        figures.append(Figure(f"{name}: share of the error at low frequencies", low, "", None))
    return figures


def _means_and_spectrum(method: Callable) -> tuple[float, float]:
    """Over greys that are no level of a matrix."""
    errors, low, total = [], 0.0, 0.0
    for grey in (np.arange(GREYS) + 0.5) / GREYS:
        shown = np.asarray(method(np.full((SIDE, SIDE), grey, np.float32)), np.float64)
        errors.append(abs(shown.mean() - grey))
        power = abs(np.fft.fft2(shown - grey)) ** 2
        across, down = (np.fft.fftfreq(side) for side in shown.shape)
        near = np.hypot(across[:, None], down) < LOW
        low, total = low + power[near].sum(), total + power.sum()
    return float(max(errors)), float(low / total)


if __name__ == "__main__":
    run("display", measure)
