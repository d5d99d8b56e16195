"""The report of a fit: one HTML page that holds everything it shows."""

from __future__ import annotations

import base64
import io
import math
import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import numpy as np

from .._result import FitResult, FitView
from ._drawing import PAGE_INKS, page_svg
from ._lengths import joined, seconds_text, stage_text
from ._sheet import contact_sheet, worst_channel, worst_of
from ._tables import (
    STATUS_WORDS,
    deviation_text,
    further_remarks,
    interval_text,
    noise_source,
    places,
    rounded,
    rounded_error,
    short,
    status_sentence,
    what_moves,
)

_LARGEST_SIDE = 1024  # pixels of a picture in the page; larger ones are averaged down
_LARGEST_MATRIX = 40  # coefficients whose correlations are still drawn
_OUTSIDE = np.array([128, 128, 128], np.uint8)  # a pixel of a map that the mask leaves out


def report_html(result: FitResult, *, title: str, truth: Mapping[str, float] | None = None) -> str:
    """The page as text: pictures, coefficients, correlations, convergence, effects and time.

    It loads nothing from anywhere: pictures are data URIs, drawings inline SVG.
    `truth` maps names of coefficients to true values and adds their columns.
    """
    import jinja2

    strict = {"autoescape": True, "undefined": jinja2.StrictUndefined}
    environment = jinja2.Environment(**strict, trim_blocks=True, lstrip_blocks=True)
    environment.filters["minus"] = lambda text: re.sub(r"(?<![\w.])-(?=[\d.])|(?<=e)-(?=\d)", "−", str(text))
    template = environment.from_string(files("fitting.telling").joinpath("report.html.j2").read_text(encoding="utf-8"))
    truth = dict(truth or {})
    return template.render(
        title=title,
        result=result,
        status_words=STATUS_WORDS[result.status],
        sentence=status_sentence(result),
        remarks=further_remarks(result),
        noise_source=noise_source(result),
        views=[_view(view) for view in result.views],
        sheet=_sheet(result),
        residual_stops=_stops("RdBu_r"),
        rows=_rows(result, truth),
        has_truth=any(coefficient.name in truth for coefficient in result.coefficients),
        has_units=any(coefficient.unit not in ("", "1") for coefficient in result.coefficients),
        moves=what_moves(result),
        undetermined=[coefficient for coefficient in result.coefficients if not coefficient.identifiable],
        correlation=_correlation(result),
        curve=_curve(result),
        seconds=seconds_text,
        stages=joined(result.stages),
        stage_text=stage_text,
        short=short,
    )


def _sheet(result: FitResult) -> dict[str, Any] | None:
    """All views on one sheet."""
    held, names = result.held_out, [view.camera for view in result.views]
    left_out = [name for name in names if held is not None and name in held.names]
    return contact_sheet(
        result.views, left_out, lambda v, factor, reach: _drawn(v, factor, _round_up(max(reach, 1e-6)))
    )


def _view(view: FitView) -> dict[str, Any]:
    """The four pictures of one camera as data URIs, with the scales that they are drawn to."""
    from diffwhitted.image import ciede2000

    inside = np.asarray(view.weight) > 0
    target, render = (np.nan_to_num(np.asarray(image, np.float64)) for image in (view.target, view.render))
    exposure = _exposure(target[inside])
    worst, reach = worst_channel(view), _reach(view)
    stops = math.log2(exposure)
    difference = ciede2000(target, render, exposure=stops)
    difference_top = _round_up(max(_percentile(difference[inside], 99.5), 1.0))
    peak = np.unravel_index(np.argmax(np.where(inside, np.abs(worst), -1.0)), inside.shape)
    height, width = inside.shape
    factor = math.ceil(max(height, width) / _LARGEST_SIDE)

    return {
        "camera": view.camera,
        "width": width,
        "height": height,
        "factor": factor,
        "exposure": exposure,
        "rmse": view.rmse,
        "share": float(inside.mean()),
        **_drawn(view, factor, reach),
        "reach": reach,
        "peak": float(worst[peak]),
        "peak_column": int(peak[1]),
        "peak_row": int(peak[0]),
        "difference": _mapped(difference, inside, factor, 0.0, difference_top, "magma"),
        "difference_top": difference_top,
        "difference_stops": _stops("magma"),
        "difference_mean": float(difference[inside].mean()) if inside.any() else 0.0,
        "difference_p95": _percentile(difference[inside], 95),
    }


def _drawn(view: FitView, factor: int, reach: float) -> dict[str, str]:
    """Target, fit and residual as data URIs."""
    from diffwhitted.image import display_codes

    inside = np.asarray(view.weight) > 0
    target, render = (np.nan_to_num(np.asarray(image, np.float64)) for image in (view.target, view.render))
    stops = math.log2(_exposure(target[inside]))
    shown = [_png(display_codes(_averaged(image, factor), 8, exposure=stops)) for image in (target, render)]
    residual = _mapped(worst_channel(view), inside, factor, -reach, reach, "RdBu_r")
    return {"target": shown[0], "render": shown[1], "residual": residual}


def _mapped(values: np.ndarray, inside: np.ndarray, factor: int, low: float, high: float, palette: str) -> str:
    """A map in colours, grey outside, as a data URI."""
    colours = _palette(palette)(np.clip((_averaged(values, factor) - low) / (high - low), 0, 1))
    colours[~_averaged(inside, factor).astype(bool)] = _OUTSIDE
    return _png(colours)


def _reach(view: FitView) -> float:
    """The end of the scale of its residuals."""
    return _round_up(max(worst_of(view), 1e-6))


def _exposure(pixels: np.ndarray) -> float:
    """A factor that brings all but the brightest 0.5 % of the values to white or below, 1 where that is near."""
    bright = _percentile(pixels, 99.5)
    return 1.0 if 0.25 <= bright <= 1.0 or bright <= 0 else float(f"{1 / bright:.2g}")


def _percentile(values: np.ndarray, percent: float) -> float:
    return float(np.percentile(values, percent)) if values.size else 0.0


def _round_up(value: float) -> float:
    """The next 1, 2 or 5 times a power of ten: a scale that reads well."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if value <= step * power * (1 + 1e-9))


def _averaged(image: np.ndarray, factor: int) -> np.ndarray:
    """Means over squares of `factor` pixels; a remainder at the right and bottom edge is left out."""
    if factor == 1:
        return image
    height, width = (side // factor for side in image.shape[:2])
    squares = image[: height * factor, : width * factor]
    return squares.reshape(height, factor, width, factor, *image.shape[2:]).mean(axis=(1, 3))


def _palette(name: str) -> Any:
    """A function from values in [0, 1] to 8-bit RGB."""
    import matplotlib

    return lambda values: matplotlib.colormaps[name](values, bytes=True)[..., :3].copy()


def _stops(palette: str) -> str:
    """The palette as the stops of a CSS gradient, low to high."""
    return ", ".join("#" + bytes(colour).hex() for colour in _palette(palette)(np.linspace(0, 1, 17)))


def _png(image: np.ndarray) -> str:
    """8-bit RGB `(H, W, 3)` as a data URI."""
    from matplotlib.image import imsave

    stream = io.BytesIO()
    imsave(stream, np.ascontiguousarray(image), format="png")
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def _rows(result: FitResult, truth: Mapping[str, float]) -> list[dict[str, Any]]:
    """What the table says of each coefficient."""
    rows, owner = [], None
    for coefficient in result.coefficients:
        error, true_value = coefficient.standard_error, truth.get(coefficient.name)
        symbol, _, index = coefficient.symbol.partition("_")
        before, owner = owner, coefficient.name.partition(".")[0]
        row = {
            "it": coefficient,
            "starts_group": before not in (None, owner),
            "symbol": symbol,
            "index": index,
            "value": rounded(coefficient.value, error),
            "error": None if error is None else rounded_error(error),
            "interval": interval_text(coefficient),
            "start": f"{coefficient.start:.4g}",
            "bar": places(coefficient, true_value),
            "truth": None,
            "errors_off": None,
        }
        if true_value is not None:
            row |= {"truth": f"{true_value:.6g}", "deviation": deviation_text(coefficient, true_value)}
            row["errors_off"] = abs(coefficient.value - true_value) / error if error else None
        rows.append(row)
    return rows


def _correlation(result: FitResult) -> dict[str, Any] | None:
    """The lower triangle of the matrix and its strongest pairs; None where there is nothing to draw."""
    names = [coefficient.name for coefficient in result.coefficients]
    matrix = np.asarray(result.correlation, np.float64)
    if not 2 <= len(names) <= _LARGEST_MATRIX:
        return None
    pairs = [(names[i], names[j], matrix[i, j]) for i in range(len(names)) for j in range(i)]
    pairs = sorted((pair for pair in pairs if math.isfinite(pair[2])), key=lambda pair: -abs(pair[2]))
    return {
        "names": names,
        "rows": [[float(entry) if math.isfinite(entry) else None for entry in row] for row in matrix],
        "strongest": [pair for pair in pairs[:5] if abs(pair[2]) >= 0.5],
        "undefined": not np.isfinite(matrix).all(),
    }


def _curve(result: FitResult) -> str | None:
    """Loss against step as inline SVG in the inks of the page; None without a step to draw."""
    points = [s for s in result.history if math.isfinite(s.loss) and s.loss > 0]
    if not points:
        return None
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    ink, muted, accent = PAGE_INKS
    kept, refused = ([s for s in points if s.accepted is kind] for kind in (True, False))
    figure = Figure(figsize=(6.6, 3.0), layout="constrained", facecolor="none")
    axes = figure.add_subplot()
    axes.plot([s.step for s in kept], [s.loss for s in kept], "-o", color=accent, markersize=4, label="step kept")
    if refused:
        axes.plot([s.step for s in refused], [s.loss for s in refused], "x", color=muted, label="step refused")
        axes.legend(frameon=False, labelcolor=ink)
    for last in np.cumsum([stage.steps for stage in result.stages])[:-1]:
        axes.axvline(last - 0.5, color=muted, linewidth=0.8, linestyle=":")
    axes.set(yscale="log", xlabel="step", ylabel="loss")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=10, min_n_ticks=1))
    axes.set_xlim(points[0].step - 0.5, points[-1].step + 0.5)
    ticks = [t for t in axes.get_xticks() if points[0].step <= t <= points[-1].step]
    times = np.interp(ticks, [s.step for s in points], [s.seconds for s in points])
    clock = axes.secondary_xaxis("top")
    clock.set_xticks(ticks, [f"{time:.3g}" for time in times])
    clock.set_xlabel("seconds since the solve began")
    axes.grid(color=muted, alpha=0.25, linewidth=0.6)
    for part in (axes, clock):
        part.tick_params(which="both", colors=muted, labelcolor=ink)
        part.xaxis.label.set_color(ink)
        part.spines[:].set_color(muted)
    axes.yaxis.label.set_color(ink)
    axes.patch.set_visible(False)
    return page_svg(figure)
