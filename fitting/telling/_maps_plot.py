"""Where a picture spends its rays, as a person sees it: the picture, and a map of each count."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from diffwhitted.image import encode_for_display

from ._outputs import explained, write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from diffwhitted import RayMaps

MOST_STEPS = 9
"""A map of no more different counts has a colour for each."""


def write_maps(maps: RayMaps, picture: np.ndarray, path: Path) -> None:
    """Write the drawing, whole or not at all. Raises `OutputError` where that fails."""
    with explained(path):
        write_whole(path, lambda temporary: maps_figure(maps, picture).savefig(temporary))


def maps_figure(maps: RayMaps, picture: np.ndarray) -> Figure:
    """Four panels."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib.figure import Figure

    height, width = maps.rays.shape
    figure = Figure(figsize=(9.6, 9.6 * height / width + 0.6), layout="constrained", dpi=120)
    panels = figure.subplots(2, 2)
    for panel in panels.flat:
        panel.set_xticks([])
        panel.set_yticks([])
    panels[0, 0].imshow(encode_for_display(np.asarray(picture)), interpolation="nearest")
    panels[0, 0].set_title("the picture, one sample a pixel", fontsize=10)
    _map(panels[0, 1], maps.rays, f"rays a sample: mean {maps.rays.mean():.2f}, most {maps.rays.max()}")
    _map(panels[1, 0], maps.depth, f"depth reached: mean {maps.depth.mean():.2f}, most {maps.depth.max()}")
    _map(
        panels[1, 1],
        maps.squares,
        f"squares of antialias {maps.threshold:g}: mean {maps.squares.mean():.2f}, most {maps.squares.max()}",
        logarithmic=True,
    )
    return figure


def _map(axes: Axes, counts: np.ndarray, title: str, logarithmic: bool = False) -> None:
    """Counts from dark to bright, with a scale beside them; a colour for each where they are few."""
    from matplotlib.colors import BoundaryNorm, LogNorm
    from matplotlib.ticker import MaxNLocator, ScalarFormatter

    low, high = int(counts.min()), int(counts.max())
    steps = high - low < MOST_STEPS
    if steps:
        edges = np.arange(low, high + 2) - 0.5
        norm = BoundaryNorm(edges, 256)
    else:
        norm = LogNorm(max(low, 1), high) if logarithmic else None
    drawn = axes.imshow(counts, cmap="viridis", norm=norm, interpolation="nearest")
    scale = axes.figure.colorbar(drawn, ax=axes, shrink=0.8, ticks=np.arange(low, high + 1) if steps else None)
    if logarithmic and not steps:
        scale.set_ticks([count for count in (1, 4, 16, 64) if low <= count <= high])
        scale.ax.yaxis.set_major_formatter(ScalarFormatter())
        scale.ax.minorticks_off()
    elif not steps:
        scale.ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_title(title, fontsize=10)
