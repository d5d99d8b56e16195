"""The files that a measured trade-off leaves in a folder, each written whole or not at all."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

from diffwhitted import KNOBS

from ._drawing import PAGE_INKS, page_svg
from ._outputs import explained, write_whole
from ._tradeoff import Tradeoff, bound_text, bound_value, seconds_text, sentences
from ._tradeoff_plot import tradeoff_figure


def write_tradeoff(found: Tradeoff, folder: Path, title: str, about: str) -> list[Path]:
    """Write `tradeoff.json`, `tradeoff.csv`, `tradeoff.png` and `tradeoff.html` and return their paths.

    The folder is made if it is missing, and files of these names in it are replaced. Raises `OutputError` where something
    cannot be written; that file is then as it was before.
    """
    jobs: dict[str, Callable[[Path], object]] = {
        "tradeoff.json": lambda path: path.write_text(json.dumps(found.to_json(), indent=2, allow_nan=False) + "\n", encoding="utf-8"),
        "tradeoff.csv": lambda path: path.write_text(tradeoff_csv(found), encoding="utf-8", newline=""),
        "tradeoff.png": lambda path: write_png(found, path),
        "tradeoff.html": lambda path: path.write_text(tradeoff_html(found, title, about), encoding="utf-8"),
    }
    with explained(folder):
        folder.mkdir(parents=True, exist_ok=True)
    for name, write in jobs.items():
        with explained(folder / name):
            write_whole(folder / name, write)
    return [folder / name for name in jobs]


def tradeoff_csv(found: Tradeoff) -> str:
    """A row a setting, with a column for every knob."""
    figures = ("rmse", "largest", "ciede2000_mean", "ciede2000_p95", "rays", "seconds")
    text = io.StringIO()
    table = csv.writer(text)
    table.writerow([*(knob.name for knob in KNOBS), *figures, "bound", "on_front", "sweeps"])
    for point in found.points:
        table.writerow([*(point.settings[knob] for knob in KNOBS), *(getattr(point, name) for name in figures), bound_value(point.bound),
                        int(point.on_front), " ".join(point.sweeps)])
    return text.getvalue()


def write_png(found: Tradeoff, path: Path) -> None:
    """The drawing on white."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = tradeoff_figure(found)
    figure.set_facecolor("white")
    FigureCanvasAgg(figure).print_figure(path, format="png", dpi=150, metadata={"Software": None})


def tradeoff_html(found: Tradeoff, title: str, about: str) -> str:
    """The page as text; it loads nothing from anywhere."""
    import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(files("fitting").joinpath("tradeoff.html.j2").read_text(encoding="utf-8"))
    ink, muted, _ = PAGE_INKS
    recommendation, own, convergence = sentences(found)
    return template.render(title=title, found=found, chosen=found.recommended, recommendation=recommendation, own=own, convergence=convergence,
                           curve=page_svg(tradeoff_figure(found, ink, muted)), seconds=seconds_text, bound=bound_text, knobs=KNOBS, about=about)
