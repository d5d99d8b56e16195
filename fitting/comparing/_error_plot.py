"""Errors against time as a drawing that reads at a glance: sweeps of knobs, the Pareto front, and names where they
tell most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._tradeoff import COMBINATION, steps_that_count, tolerance_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#0072b2", "#cc79a7", "#d55e00", "#009e73", "#8c6d1f", "#7b5ea7")
"""Of the sweeps, told apart also by the colour-blind (Okabe and Ito 2008); further rows of the table begin again."""
_MARKERS = "osD^vP"
MOST_LABELS = 7
_PLACES = (
    (7, 6, "left", "bottom"),
    (-7, -6, "right", "top"),
    (-7, 6, "right", "bottom"),
    (7, -6, "left", "top"),
    (0, 14, "center", "bottom"),
    (0, -14, "center", "top"),
    (10, 0, "left", "center"),
    (-12, -14, "right", "top"),
)
"""Where a label may stand beside its point: offset in points, and which of its sides is there."""


@dataclass(frozen=True, eq=False)
class Mark:
    """A measured setting as a point of the drawing."""

    text: str
    values: Mapping[str, Any]
    """By the names of the knobs."""
    sweeps: tuple[str, ...]
    """The knobs in whose sweep it lies, or "combination"."""
    seconds: float
    error: float
    on_front: bool


@dataclass(frozen=True)
class Words:
    """What stands beside the axes, and their colours."""

    time: str
    error: str
    ink: str = "#1c2024"
    muted: str = "#626a73"


def error_figure(
    marks: Sequence[Mark],
    knobs: Sequence,
    words: Words,
    *,
    tolerance: float | None = None,
    best: Mark | None = None,
    named: Sequence[Mark] = (),
    idle: Sequence[Mark] = (),
    size: tuple[float, float] = (8.4, 5.2),
) -> Figure:
    """The sweeps and the Pareto front on logarithmic axes; times from left to right.

    - `knobs`: rows of a table, each with `name` and `sweep`.
    - `tolerance`: a line across; `best`: ringed, its name bold.
    - `named`: named first, after `best`; then the steps of the front, where there is room.
    - `idle`: crossed out in grey, since nobody would use them.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained", facecolor="none")
    axes = figure.add_subplot()
    axes.set(xscale="log", yscale="log", xlabel=words.time, ylabel=words.error)
    front = [m for m in marks if m.on_front]
    axes.plot(
        *_places(front),
        "-",
        color=words.muted,
        linewidth=7,
        alpha=0.3,
        solid_capstyle="round",
        solid_joinstyle="round",
        label="nothing measured is better (Pareto front)",
    )
    for number, knob in enumerate(knobs):
        line = _sweep(marks, knob)
        if len(line) > 1:
            axes.plot(
                *_places(line),
                color=_COLOURS[number % len(_COLOURS)],
                linewidth=1.3,
                marker=_MARKERS[number % len(_MARKERS)],
                markersize=4.5,
                label=f"{knob.name}: {_range(line, knob.name)}",
            )
    rest = [m for m in marks if COMBINATION in m.sweeps]
    if rest:
        axes.plot(*_places(rest), "x", color=words.ink, markersize=5, label="combinations")
    if idle:
        axes.plot(
            *_places(idle), "X", color=words.muted, markersize=9, label="did not converge, or not all is determined"
        )
    if tolerance is not None:
        axes.axhline(tolerance, color=words.ink, linewidth=1, linestyle=(0, (6, 4)))
        axes.annotate(
            f"tolerance {tolerance_text(tolerance)}",
            (0.005, tolerance),
            xycoords=("axes fraction", "data"),
            xytext=(0, 3),
            textcoords="offset points",
            fontsize=9,
            color=words.ink,
        )
    _dress(axes, words.ink, words.muted)
    axes.margins(0.1, 0.12)
    figure.draw_without_rendering()
    chosen = [mark for mark in (best, *named, *front[-1:], *front[:1]) if mark is not None]
    _label(
        axes, list(dict.fromkeys((*chosen, *steps_that_count(front, lambda m: m.error))))[:MOST_LABELS], best, words.ink
    )
    if best is not None:
        axes.plot(
            [best.seconds],
            [best.error],
            "o",
            color=words.ink,
            markersize=11,
            markerfacecolor="none",
            markeredgewidth=1.8,
        )
    return figure


def write_figure(figure: Figure, path: Path) -> None:
    """As a PNG on white."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_facecolor("white")
    FigureCanvasAgg(figure).print_figure(path, format="png", dpi=150, metadata={"Software": None})


def _places(marks: Sequence[Mark]) -> tuple[list[float], list[float]]:
    return [m.seconds for m in marks], [m.error for m in marks]


def _sweep(marks: Sequence[Mark], knob) -> list[Mark]:
    """The points of a sweep, in the order of the values of its knob."""
    line = [m for m in marks if knob.name in m.sweeps]
    return sorted(
        line, key=lambda m: knob.sweep.index(m.values[knob.name]) if m.values[knob.name] in knob.sweep else -1
    )


def _range(line: Sequence[Mark], name: str) -> str:
    first, last = (line[end].values[name] for end in (0, -1))
    return f"{first:.2g} to {last:.2g}" if isinstance(last, float) else f"{first} to {last}"


def _dress(axes: Axes, ink: str, muted: str) -> None:
    """Axes that read as numbers, and a legend, in these inks."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=20))
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value:g} s" if value >= 1 else f"{1000 * value:g} ms")
    )
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=20))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(LogLocator(subs="all", numticks=50))
        axis.set_minor_formatter(FuncFormatter(lambda value, _: ""))
        axis.label.set_color(ink)
    axes.grid(color=muted, alpha=0.25, linewidth=0.6)
    axes.tick_params(which="both", colors=muted, labelcolor=ink)
    axes.spines[:].set_color(muted)
    axes.spines[["top", "right"]].set_visible(False)
    axes.patch.set_visible(False)
    axes.legend(frameon=False, labelcolor=ink, fontsize=9, loc="upper center", bbox_to_anchor=(0.45, -0.12), ncols=2)


def _drawn(axes: Axes) -> list:
    """Places on the page along all lines, a few pixels apart."""
    import numpy as np

    dots = []
    for line in axes.lines:
        corners = line.get_transform().transform(line.get_xydata())
        dots += list(corners)
        if line.get_linestyle() != "None":
            for start, end in zip(corners[:-1], corners[1:], strict=True):
                steps = np.linspace(0, 1, 2 + int(np.hypot(*(end - start)) / 4))[:, None]
                dots += list(start + steps * (end - start))
    return dots


def _label(axes: Axes, marks: Sequence[Mark], best: Mark | None, ink: str) -> None:
    """Name these, each where there is room."""
    taken = [line.get_window_extent() for line in axes.texts]
    dots = _drawn(axes)
    for mark in marks:
        for x, y, across, along in _PLACES:
            text = axes.annotate(
                mark.text,
                (mark.seconds, mark.error),
                xytext=(x, y),
                textcoords="offset points",
                ha=across,
                va=along,
                fontsize=9,
                color=ink,
                fontweight="bold" if mark is best else "normal",
            )
            box = text.get_window_extent().padded(3)
            covered = any(box.contains(*dot) for dot in dots)
            inside = axes.bbox.padded(4).contains(box.x0, box.y0) and axes.bbox.padded(4).contains(box.x1, box.y1)
            if inside and not covered and not any(box.overlaps(other) for other in taken):
                taken.append(box)
                break
            text.remove()
