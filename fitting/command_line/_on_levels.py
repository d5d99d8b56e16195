"""`render --display`: the picture on the few levels of a display."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

DisplayName = Annotated[
    str | None,
    typer.Option(
        "--display",
        metavar="METHOD",
        show_default=False,
        help="Show it on few levels: ordered:N (dither by a matrix of N x N, default 4), halftone:N (patterns of "
        "N x N a pixel, default 3), error-diffusion, serpentine (the same, rows to and fro), dot-diffusion, "
        "random:SEED.",
    ),
]
Levels = Annotated[
    int, typer.Option("--levels", metavar="L", help="With --display: levels of each channel, evenly spaced in light.")
]

METHODS = {"ordered": 4, "halftone": 3, "error-diffusion": None, "serpentine": None, "dot-diffusion": None, "random": 0}
"""Each with the number that may follow it: the size n, the seed, or none."""


def chosen_method(display: str, levels: int, out: Path) -> Callable[[Any], Any]:
    """What makes the picture of few levels out of one in [0, 1]. Raises `InputError`."""
    import jax

    from diffwhitted import InputError
    from diffwhitted import display as on_levels

    word, _, number = display.partition(":")
    usual = METHODS.get(word)
    if word not in METHODS or (number and (usual is None or not number.isdigit())):
        raise InputError(
            f"--display {display}: allowed is ordered or ordered:N, halftone or halftone:N, error-diffusion, "
            "serpentine, dot-diffusion, and random or random:SEED"
        )
    if out.suffix.lower() in (".jpg", ".jpeg"):
        raise InputError(f"--display {display}: {out} would blur the dots; write .png, or .exr")
    if not 2 <= levels <= 256:
        raise InputError(f"--levels {levels}: allowed is 2 to 256")
    size = int(number) if number else usual
    if word in ("ordered", "halftone"):
        on_levels.dither_matrix(size)  # pyright: ignore[reportArgumentType]
    methods: dict[str, Callable[[Any], Any]] = {
        "ordered": lambda image: on_levels.ordered_dither(image, size, levels),  # pyright: ignore[reportArgumentType]
        "halftone": lambda image: on_levels.halftone(image, size, levels),
        "error-diffusion": lambda image: on_levels.error_diffusion(image, levels),
        "serpentine": lambda image: on_levels.error_diffusion(image, levels, serpentine=True),
        "dot-diffusion": lambda image: on_levels.dot_diffusion(image, levels),
        "random": lambda image: on_levels.random_dither(image, jax.random.key(size or 0), levels),
    }
    return methods[word]


def write_on_levels(out: Path, pixels, method: Callable[[Any], Any], levels: int, exposure: float, about: dict) -> None:
    """Write the picture: as a PNG of a palette where its colours are few enough."""
    import numpy as np

    from diffwhitted import display as on_levels
    from diffwhitted import write_image
    from diffwhitted.image._palette import LARGEST_PALETTE

    exposed = np.asarray(pixels) * 2.0**exposure
    shown = np.asarray(method(on_levels.fit_range(exposed)))
    colours = len(np.unique(np.rint(shown * (levels - 1)).reshape(-1, 3), axis=0))
    if out.suffix.lower() == ".png" and colours <= LARGEST_PALETTE:
        on_levels.write_palette(out, shown, levels, metadata=about)
    else:
        write_image(out, shown, metadata=about)
