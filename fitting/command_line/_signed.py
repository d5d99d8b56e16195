"""Pictures of signed values: red above zero, blue below, white at zero, with a scale beside them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fitting.telling._outputs import explained, write_whole

SHOWN = 99.5
"""Percentile of the values at which the colours end; a few pixels may be far beyond."""


def signed_picture(path: Path, images: Sequence[np.ndarray], name: str) -> None:
    """Write the mean over the channels of one picture, or of two side by side, whole or not at all."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib.figure import Figure

    shown = [image.mean(axis=-1) for image in images]
    limit = max(float(np.percentile(abs(np.stack(shown)), SHOWN)), 1e-12)
    height, width = shown[0].shape
    panels = Figure(figsize=(5.2 * len(shown) + 0.9, 5.2 * height / width + 0.5), layout="constrained", dpi=120)
    axes = np.atleast_1d(panels.subplots(1, len(shown)))
    titles = [f"d image / d {name}", "central difference of supersampled pictures"]
    for axis, values, title in zip(axes, shown, titles, strict=False):
        drawn = axis.imshow(values, cmap="RdBu_r", vmin=-limit, vmax=limit, interpolation="nearest")
        axis.set_title(title, fontsize=10)
        axis.set_xticks([])
        axis.set_yticks([])
    panels.colorbar(drawn, ax=list(axes), shrink=0.9, extend="both", label="linear RGB, mean of the channels")
    with explained(path):
        write_whole(path, panels.savefig)
