"""Error against time of a `Tradeoff` as a drawing that reads at a glance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from diffwhitted import KNOBS

from ._tradeoff import COMBINATION, Point, Tradeoff, tolerance_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#0072b2", "#cc79a7", "#d55e00", "#009e73", "#8c6d1f", "#7b5ea7")
"""Of the sweeps, told apart also by the colour-blind (Okabe and Ito 2008); further rows of the table begin again."""
_MARKERS = "osD^vP"
MOST_LABELS = 7
_PLACES = ((7, 6, "left", "bottom"), (-7, -6, "right", "top"), (-7, 6, "right", "bottom"), (7, -6, "left", "top"),
           (0, 14, "center", "bottom"), (0, -14, "center", "top"), (10, 0, "left", "center"), (-12, -14, "right", "top"))
"""Where a label may stand beside its point: offset in points, and which of its sides is there."""


def tradeoff_figure(found: Tradeoff, ink: str = "#1c2024", muted: str = "#626a73", size: tuple[float, float] = (8.4, 5.2)) -> Figure:
    """The sweeps, the Pareto front and the tolerance, on logarithmic axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained", facecolor="none")
    axes = figure.add_subplot()
    axes.set(xscale="log", yscale="log", xlabel=f"time for {found.width} x {found.height} pixels", ylabel="error: RMSE in linear RGB")
    front = [p for p in found.points if p.on_front]
    axes.plot([p.seconds for p in front], [p.rmse for p in front], "-", color=muted, linewidth=7, alpha=0.3, solid_capstyle="round",
              solid_joinstyle="round", label="nothing measured is better (Pareto front)")
    for number, knob in enumerate(KNOBS):
        line = _sweep(found, knob.name)
        if len(line) > 1:
            axes.plot([p.seconds for p in line], [p.rmse for p in line], color=_COLOURS[number % len(_COLOURS)], linewidth=1.3,
                      marker=_MARKERS[number % len(_MARKERS)], markersize=4.5, label=f"{knob.name}: {_range(line, knob)}")
    rest = [p for p in found.points if COMBINATION in p.sweeps]
    axes.plot([p.seconds for p in rest], [p.rmse for p in rest], "x", color=ink, markersize=5, label="combinations")
    axes.axhline(found.tolerance, color=ink, linewidth=1, linestyle=(0, (6, 4)))
    axes.annotate(f"tolerance {tolerance_text(found.tolerance)}", (0.005, found.tolerance), xycoords=("axes fraction", "data"),
                  xytext=(0, 3), textcoords="offset points", fontsize=9, color=ink)
    _dress(axes, ink, muted)
    axes.margins(0.1, 0.12)
    figure.draw_without_rendering()
    _label(axes, found, ink)
    return figure


def _sweep(found: Tradeoff, name: str) -> list[Point]:
    """The points of a sweep, in the order of the values of its knob."""
    (knob,) = (knob for knob in KNOBS if knob.name == name)
    line = [p for p in found.points if name in p.sweeps]
    return sorted(line, key=lambda p: knob.sweep.index(p.settings[knob]) if p.settings[knob] in knob.sweep else -1)


def _range(line: list[Point], knob) -> str:
    first, last = (line[end].settings[knob] for end in (0, -1))
    return f"{first:.2g} to {last:.2g}" if isinstance(last, float) else f"{first} to {last}"


def _dress(axes: Axes, ink: str, muted: str) -> None:
    """Axes that read as numbers, and a legend, in these inks."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=20))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g} s" if value >= 1 else f"{1000 * value:g} ms"))
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


def _label(axes: Axes, found: Tradeoff, ink: str) -> None:
    """Name the recommended settings, those of the scene, the ends of the front, and more of it where there is room."""
    front = [p for p in found.points if p.on_front]
    own = [p for p in found.points if p.settings == found.asked]
    first = [p for p in (found.recommended, *own, front[-1], front[0]) if p is not None]
    taken = [line.get_window_extent() for line in axes.texts]
    dots = _drawn(axes)
    for point in list(dict.fromkeys((*first, *front)))[:MOST_LABELS]:
        for x, y, across, along in _PLACES:
            bold = point is found.recommended
            text = axes.annotate(str(point.settings), (point.seconds, point.rmse), xytext=(x, y), textcoords="offset points", ha=across,
                                 va=along, fontsize=9, color=ink, fontweight="bold" if bold else "normal")
            box = text.get_window_extent().padded(3)
            covered = any(box.contains(*dot) for dot in dots)
            inside = axes.bbox.padded(4).contains(box.x0, box.y0) and axes.bbox.padded(4).contains(box.x1, box.y1)
            if inside and not covered and not any(box.overlaps(other) for other in taken):
                taken.append(box)
                break
            text.remove()
    if found.recommended is not None:
        best = found.recommended
        axes.plot([best.seconds], [best.rmse], "o", color=ink, markersize=11, markerfacecolor="none", markeredgewidth=1.8)
