"""`diffwhitted tradeoff`: what accuracy costs in time for one scene."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ._environment import set_up
from ._options import CameraName, Height, ScenePath, Width, chosen_camera, with_camera
from ._progress import Progress, safe, say

if TYPE_CHECKING:
    from rich.table import Table

    from diffwhitted import Scene
    from fitting.comparing._tradeoff import Point, Tradeoff
    from fitting.comparing._tradeoff_fit import FitPoint, FitTradeoff

Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        metavar="DIR",
        show_default=False,
        help="Folder for tradeoff.html, tradeoff.png, tradeoff.csv and tradeoff.json, and of fits "
        "tradeoff-fit.png and tradeoff-fit.csv.",
    ),
]
Tolerance = Annotated[
    str,
    typer.Option(
        "--tolerance",
        metavar="ERROR",
        help="Largest RMSE in linear RGB, a number or a fraction, to recommend settings for.",
    ),
]
Free = Annotated[
    list[str] | None,
    typer.Option(
        "--free",
        metavar="NAME",
        show_default=False,
        help='Measure fits too: coefficient to find, MATERIAL.COEFFICIENT. Wildcards in quotes: "*.k_d", "glass.*".',
    ),
]
Start = Annotated[
    list[str] | None,
    typer.Option(
        "--start",
        metavar="NAME=VALUE",
        show_default=False,
        help="Where the fits begin; wildcards allowed. Default: the middle of the bounds.",
    ),
]
PICTURES = 0.3
"""Part of the work that the pictures are where fits are measured too."""
Json = Annotated[bool, typer.Option("--json", help="Print JSON in place of the table.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No live progress.")]


def tradeoff(
    scene: ScenePath,
    camera: CameraName = None,
    width: Width = None,
    height: Height = None,
    out: Out = None,
    tolerance: Tolerance = "1/255",
    free: Free = None,
    start: Start = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure what accuracy costs in time, and recommend settings.

    \b
    Depth, cutoff, samples and footprints of a scene, as a table and a plot:
      diffwhitted tradeoff scene.toml --width 320 --out accuracy

    \b
    What it costs to find the glass and the mirror again, and how far off each coefficient is:
      diffwhitted tradeoff scene.toml --width 160 --free "glass.k_*" --free mirror.k_s --out accuracy

    Every knob is swept, alone and in the combinations that may be useful; errors are against a reference of far more
    rays, which is stated with its own convergence. "Left out, at most" is a certain bound: no channel of a pixel
    would be brighter by more if depth and cutoff ended no branch of its samples. Takes a minute or so at 320 x 240,
    more for larger pictures.

    With --free the scene's own coefficients are the truth: fits look for them in the reference picture, from the
    middle of their bounds, with each depth, cutoff, number of samples and footprint. Their errors come from what
    those settings show falsely. Every setting compiles a program of its own, so the first time takes some minutes
    more. The other commands render with what is found by --depth, --cutoff, --samples and --footprint, or find it for
    themselves by render --tolerance.
    """
    set_up("float64")
    with Progress("reading", quiet=quiet) as progress:
        from diffwhitted import load_scene
        from fitting import Target
        from fitting.comparing._tradeoff import sentences
        from fitting.comparing._tradeoff import tradeoff as measure
        from fitting.comparing._tradeoff_fit import recommendation
        from fitting.comparing._tradeoff_fit import tradeoff_of_fits as measure_fits
        from fitting.comparing._tradeoff_outputs import tradeoff_json, write_tradeoff

        from ._accuracy import tolerance_number
        from ._folder import check_folder
        from ._named_values import numbers

        largest = tolerance_number(tolerance)
        loaded = load_scene(scene)
        name, view = chosen_camera(loaded, camera)
        if out is not None:
            check_folder(out)
        loaded, begin = with_camera(loaded, name, view.resized(width, height)), numbers("--start", start or [])
        check_free(loaded, free, begin)
        pictures = PICTURES if free else 1.0
        found = measure(
            loaded, loaded.cameras[name], largest, on_work=lambda text, done: progress.part(text, pictures * done)
        )
        fits = None
        if free:
            fits = measure_fits(
                loaded,
                Target(found.picture, name),
                free,
                start=begin,
                on_work=lambda text, done: progress.part(text, pictures + (1 - pictures) * done),
            )
        title, about = (
            f"{scene.stem}: what accuracy costs in time",
            f"{scene.name}, camera {name}, {found.width} x {found.height} pixels",
        )
        progress.say("writing")
        written = write_tradeoff(found, out, title, about, fits) if out is not None else []
    if json:
        from json import dumps

        print(dumps({"scene": str(scene), "camera": name} | tradeoff_json(found, fits), indent=2, allow_nan=False))
        return
    print_tradeoff(found, about)
    print()
    for sentence in sentences(found):
        say(textwrap.fill(sentence, 80))
    if fits is not None:
        print()
        print_fits(fits)
        print()
        say(textwrap.fill(recommendation(fits), 80))
    if written:
        say(f"Page: {written[-1]}")


def check_free(scene: Scene, free: list[str] | None, start: dict[str, float]) -> None:
    """Raise `FitError` now rather than after the pictures for names that are none."""
    from diffwhitted import InputError
    from fitting.problem._free_names import free_parameters
    from fitting.problem._unknowns import list_unknowns, start_values

    if free:
        names, _ = free_parameters(scene, free)
        start_values(scene, list_unknowns(scene, names), start)
    elif start:
        raise InputError("--start without --free: there is no fit to begin; name coefficients with --free")


def print_tradeoff(found: Tradeoff, title: str) -> None:
    """The front and the recommended settings, in 80 columns and without colour; all settings are in the files."""
    from rich.console import Console

    console = Console(highlight=False)
    say(textwrap.fill(f"{title}; medians of {found.rounds} runs, {found.seconds_compile:.0f} s of compiling", 80))
    console.print("", _table(found), sep="\n")
    hidden = len(found.points) - len(_shown(found))
    console.print(
        f"\n{hidden} more settings were measured: beaten by one of these, or better by less than a fifth.", markup=False
    )


def _shown(found: Tradeoff) -> list[Point]:
    """The front in steps that count, the settings of the scene and the recommended ones."""
    from fitting.comparing._tradeoff import steps_that_count

    steps = steps_that_count([p for p in found.points if p.on_front], lambda p: p.rmse)
    return [p for p in found.points if p in steps or p is found.recommended or p.settings == found.asked]


def _table(found: Tradeoff) -> Table:
    from fitting.comparing._tradeoff import bound_text, seconds_text

    from ._explain import plain_table

    table = plain_table("", "settings", "time", "RMSE", "CIEDE\n2000", "left out,\nat most")
    for column in table.columns[2:]:
        column.justify = "right"
    for point in _shown(found):
        mark = ">" if point is found.recommended else ""
        figures = (f"{value:.2g}" for value in (point.rmse, point.ciede2000_mean))
        table.add_row(mark, str(point.settings), seconds_text(point.seconds), *figures, bound_text(point.bound))
    return table


def print_fits(found: FitTradeoff) -> None:
    """The front, the defaults and the recommended settings of fits, in 80 columns."""
    from rich.console import Console

    from fitting.comparing._tradeoff import seconds_text

    from ._explain import plain_table

    say(
        textwrap.fill(
            f"Fits of {', '.join(found.start)}; medians of {found.rounds} runs, {found.seconds_compile:.0f} s of "
            "compiling",
            80,
        )
    )
    table = plain_table("", "settings", "time", "steps", "largest\nerror", "of", "intervals\nthat hold")
    for column in (*table.columns[2:5], table.columns[6]):
        column.justify = "right"
    shown = _shown_fits(found)
    for p in shown:
        mark = ">" if p is found.recommended else ""
        figures = str(p.steps), f"{p.largest:.2g}", safe(p.worst.name), f"{p.covered} of {len(p.coefficients)}"
        table.add_row(mark, str(p.settings), seconds_text(p.seconds), *figures)
    console = Console(highlight=False)
    console.print("", table, sep="\n")
    if hidden := len(found.points) - len(shown):
        text = (
            f"{hidden} more fits were measured: beaten by one of these, better by less than a fifth, or "
            "without an answer."
        )
        say("\n" + textwrap.fill(text, 80))


def _shown_fits(found: FitTradeoff) -> list[FitPoint]:
    """The front in steps that count, the defaults and the recommended ones."""
    from fitting.comparing._tradeoff import steps_that_count

    steps = steps_that_count([p for p in found.points if p.on_front], lambda p: p.largest)
    return [p for p in found.points if p in steps or p is found.recommended or p.settings == found.default]
