"""The files that a measured trade-off leaves in a folder: all of one run, or recognisably not whole."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable
from importlib.resources import files
from pathlib import Path

from diffwhitted import KNOBS

from ..telling._drawing import PAGE_INKS, page_svg
from ..telling._outputs import write_together
from ._error_plot import write_figure
from ._tradeoff import Tradeoff, bound_text, bound_value, seconds_text, sentences
from ._tradeoff_fit import FitTradeoff, recommendation
from ._tradeoff_plot import fit_figure, tradeoff_figure


def write_tradeoff(
    found: Tradeoff, folder: Path, title: str, about: str, fits: FitTradeoff | None = None
) -> list[Path]:
    """Write `tradeoff.json`, `tradeoff.csv` and `tradeoff.png`, of fits `tradeoff-fit.csv` and `tradeoff-fit.png`,
    and last `tradeoff.html`.

    Returns their paths. The folder is made if it is missing, and files of these names in it are replaced. Raises
    `OutputError` where something cannot be written (see `write_together`).
    """
    jobs: dict[str, Callable[[Path], object]] = {
        "tradeoff.json": lambda path: path.write_text(
            json.dumps(tradeoff_json(found, fits), indent=2, allow_nan=False) + "\n", encoding="utf-8"
        ),
        "tradeoff.csv": lambda path: path.write_text(tradeoff_csv(found), encoding="utf-8", newline=""),
        "tradeoff.png": lambda path: write_figure(tradeoff_figure(found), path),
    }
    if fits is not None:
        jobs |= {
            "tradeoff-fit.csv": lambda path: path.write_text(fit_csv(fits), encoding="utf-8", newline=""),
            "tradeoff-fit.png": lambda path: write_figure(fit_figure(fits), path),
        }
    jobs["tradeoff.html"] = lambda path: path.write_text(tradeoff_html(found, title, about, fits), encoding="utf-8")
    return write_together(folder, jobs, last="tradeoff.json")


def tradeoff_json(found: Tradeoff, fits: FitTradeoff | None = None) -> dict:
    """Pictures, and fits under the key "fit"."""
    return found.to_json() | ({} if fits is None else {"fit": fits.to_json()})


def tradeoff_csv(found: Tradeoff) -> str:
    """A row a setting, with a column for every knob."""
    figures = ("rmse", "largest", "ciede2000_mean", "ciede2000_p95", "rays", "seconds")
    head = [*(knob.name for knob in KNOBS), *figures, "bound", "on_front", "sweeps"]
    return _csv(
        head,
        (
            [
                *(point.settings[knob] for knob in KNOBS),
                *(getattr(point, name) for name in figures),
                bound_value(point.bound),
                int(point.on_front),
                " ".join(point.sweeps),
            ]
            for point in found.points
        ),
    )


def fit_csv(fits: FitTradeoff) -> str:
    """A row a setting; of every coefficient its value, its error, and the error as a share of its bounds and of its
    interval.
    """
    figures = ("seconds", "steps", "status", "largest")
    parts = {"": "value", " error": "error", " of_bounds": "of_bounds", " of_interval": "of_interval"}
    head = [
        *fits.default.named(),
        *figures,
        "largest_of",
        "on_front",
        "sweeps",
        *(name + part for name in fits.start for part in parts),
    ]
    return _csv(
        head,
        (
            [
                *point.settings.named().values(),
                *(getattr(point, name) for name in figures),
                point.worst.name,
                int(point.on_front),
                " ".join(point.sweeps),
                *(getattr(c, part) for c in point.coefficients for part in parts.values()),
            ]
            for point in fits.points
        ),
    )


def _csv(head: Iterable, rows: Iterable[Iterable]) -> str:
    text = io.StringIO()
    table = csv.writer(text)
    table.writerow(head)
    table.writerows(rows)
    return text.getvalue()


def tradeoff_html(found: Tradeoff, title: str, about: str, fits: FitTradeoff | None = None) -> str:
    """The page as text; it loads nothing from anywhere."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    template = environment.from_string(
        files("fitting.comparing").joinpath("tradeoff.html.j2").read_text(encoding="utf-8")
    )
    inks = PAGE_INKS[:2]
    said, own, convergence = sentences(found)
    of_fits = (
        {}
        if fits is None
        else {
            "fit_sentence": recommendation(fits),
            "fit_curve": page_svg(fit_figure(fits, *inks)),
            "fit_chosen": fits.recommended,
        }
    )
    return template.render(
        title=title,
        found=found,
        chosen=found.recommended,
        recommendation=said,
        own=own,
        convergence=convergence,
        curve=page_svg(tradeoff_figure(found, *inks)),
        seconds=seconds_text,
        bound=bound_text,
        knobs=KNOBS,
        about=about,
        fits=fits,
        **of_fits,
    )
