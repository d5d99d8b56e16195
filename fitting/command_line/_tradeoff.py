"""`diffwhitted tradeoff`: what accuracy costs in time for one scene."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ._environment import set_up
from ._options import CameraName, Height, ScenePath, Width, chosen_camera
from ._progress import Progress

if TYPE_CHECKING:
    from rich.table import Table

    from fitting._tradeoff import Point, Tradeoff

Out = Annotated[Path | None, typer.Option(
    "--out", "-o", metavar="DIR", show_default=False, help="Folder for tradeoff.html, tradeoff.png, tradeoff.csv and tradeoff.json.")]
Tolerance = Annotated[str, typer.Option(
    "--tolerance", metavar="ERROR", help="Largest RMSE in linear RGB, a number or a fraction, to recommend settings for.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON in place of the table.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No live progress.")]


def tradeoff(
    scene: ScenePath, camera: CameraName = None, width: Width = None, height: Height = None, out: Out = None,
    tolerance: Tolerance = "1/255", json: Json = False, quiet: Quiet = False,
) -> None:
    """Measure what accuracy costs in time, and recommend settings.

    \b
    Depth, cutoff, samples and footprints of a scene, as a table and a plot:
      diffwhitted tradeoff scene.toml --width 320 --out accuracy

    Every knob is swept, alone and in the combinations that may be useful; errors are against a reference of far more
    rays, which is stated with its own convergence. Takes a minute or so at 320 x 240, more for larger pictures. The other
    commands render with what is found by --depth, --cutoff, --samples and --footprint, or find it for themselves by render
    --tolerance.
    """
    set_up("float64")
    with Progress("reading", quiet=quiet) as progress:
        from diffwhitted import load_scene
        from fitting._tradeoff import sentences
        from fitting._tradeoff import tradeoff as measure
        from fitting._tradeoff_outputs import write_tradeoff

        from ._accuracy import tolerance_number
        from ._fit import check_folder

        largest = tolerance_number(tolerance)
        loaded = load_scene(scene)
        name, view = chosen_camera(loaded, camera)
        if out is not None:
            check_folder(out)
        found = measure(loaded, view.resized(width, height), largest, on_work=progress.part)
        title, about = f"{scene.stem}: what accuracy costs in time", f"{scene.name}, camera {name}, {found.width} x {found.height} pixels"
        progress.say("writing")
        written = write_tradeoff(found, out, title, about) if out is not None else []
    if json:
        from json import dumps

        print(dumps({"scene": str(scene), "camera": name} | found.to_json(), indent=2, allow_nan=False))
        return
    print_tradeoff(found, about)
    print()
    for sentence in sentences(found):
        print(textwrap.fill(sentence, 100))
    if written:
        print(f"Page: {written[-1]}")


def print_tradeoff(found: Tradeoff, title: str) -> None:
    """The front and the recommended settings, in 80 columns and without colour; all settings are in the files."""
    from rich.console import Console

    console = Console(highlight=False)
    console.print(f"{title}; medians of {found.rounds} runs, {found.seconds_compile:.0f} s of compiling", markup=False)
    console.print()
    console.print(_table(found))
    hidden = len(found.points) - len(_shown(found))
    console.print(f"\n{hidden} more settings were measured: beaten by one of these, or better by less than a fifth.", markup=False)


def _shown(found: Tradeoff) -> list[Point]:
    """The front in steps that count, the settings of the scene and the recommended ones."""
    from fitting._tradeoff import STEP

    shown, last = [], float("inf")
    for point in found.points:
        step = point.on_front and point.rmse <= STEP * last
        if step or point is found.recommended or point.settings == found.asked:
            shown.append(point)
            last = min(last, point.rmse)
    return shown


def _table(found: Tradeoff) -> Table:
    from fitting._tradeoff import bound_text, seconds_text

    from ._explain import plain_table

    table = plain_table("", "settings", "time", "RMSE", "CIEDE\n2000", "left out,\nat most")
    for column in table.columns[2:]:
        column.justify = "right"
    for point in _shown(found):
        mark = ">" if point is found.recommended else ""
        figures = (f"{value:.2g}" for value in (point.rmse, point.ciede2000_mean))
        table.add_row(mark, str(point.settings), seconds_text(point.seconds), *figures, bound_text(point.bound))
    return table
