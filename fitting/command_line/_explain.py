"""`diffwhitted explain`: which effects a picture calls for, what they cost, and which rays it takes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Annotated

import typer

from ._environment import set_up
from ._options import CameraName, Depth, Height, ScenePath, Width, chosen_camera
from ._progress import Progress

if TYPE_CHECKING:
    from rich.table import Table

    from diffwhitted import Explanation, Scene
    from diffwhitted._explain import RayCounts

Free = Annotated[list[str] | None, typer.Option(
    "--free", metavar="NAME", show_default=False,
    help='Coefficient that a fit leaves free, so that its effect stays on at 0. Wildcards in quotes: "*.k_s".')]
Json = Annotated[bool, typer.Option("--json", help="Print JSON in place of the tables.")]
Measure = Annotated[bool, typer.Option(
    "--measure/--no-measure", help="Measure each effect's share of the time; takes some seconds for each effect that is on.")]


def explain(
    scene: ScenePath, camera: CameraName = None, free: Free = None, depth: Depth = None, width: Width = None,
    height: Height = None, json: Json = False, measure: Measure = True,
) -> None:
    """Say which effects a scene calls for, why, what each costs, and which rays there are.

    \b
    What would a fit of all mirrors and glass cost?
      diffwhitted explain scene.toml --free "*.k_s" "*.k_t"
    """
    set_up()
    with Progress("reading") as progress:
        from diffwhitted import explain as find_out
        from diffwhitted import load_scene

        loaded = load_scene(scene)
        name, view = chosen_camera(loaded, camera)
        names = _free_names(loaded, free or [])
        progress.say("counting rays")
        explanation = find_out(loaded, view.resized(width, height), free=names, max_depth=depth, measure=measure,
                               on_measure=lambda effect: progress.say(f"compiling the picture without {_words(effect)}"))
    if json:
        from json import dumps

        print(dumps({"scene": str(scene), "camera": name, "free": list(names)} | explanation.to_json(), indent=2, allow_nan=False))
    else:
        print_explanation(explanation, f"{scene}, camera {name}")


def _free_names(scene: Scene, patterns: list[str]) -> tuple[str, ...]:
    if not patterns:
        return ()
    from fitting._unknowns import free_coefficients

    return free_coefficients(scene, patterns)[0]


def print_explanation(explanation: Explanation, title: str) -> None:
    """Tables of effects and rays that read at 80 columns, without colour."""
    from rich.console import Console

    console, rays = Console(highlight=False), explanation.rays
    sentences = [f"{rays.background:,} of the rays ({rays.background / rays.total:.0%}) met nothing.",
                 f"Beside them, {rays.shadow:,} shadow rays went from lit points to lights."]
    if cut := sum(rays.cut_off.values()):
        sentences.append(f"{cut:,} more lie past depth {explanation.max_depth} and bring no light; a larger --depth follows them.")
    console.print(f"{title}: {explanation.width} x {explanation.height} pixels, depth {explanation.max_depth}", markup=False)
    if explanation.seconds is not None:
        console.print(f"{1000 * explanation.seconds:.3g} ms a picture; the share of an effect is what the picture gains without it")
    for part in (_effect_table(explanation), _ray_table(explanation.rays), " ".join(sentences)):
        console.print()
        console.print(part)


def _effect_table(explanation: Explanation) -> Table:
    from rich.text import Text

    measured = explanation.seconds is not None
    table = plain_table("effect", "", *(["share"] if measured else []), "why")
    for effect in explanation.effects:
        share = "" if effect.share is None else "below noise" if effect.below_noise else f"{effect.share:.0%}"
        table.add_row(_words(effect.name), "on" if effect.on else "off", *([share] if measured else []), Text(effect.why))
    if measured:
        table.columns[2].justify = "right"
    return table


def _ray_table(rays: RayCounts) -> Table:
    table = plain_table("rays of level", "count", "", "of kind", "count", footers=("all", f"{rays.total:,}", "", "all", f"{rays.total:,}"))
    for number in (1, 4):
        table.columns[number].justify = "right"
    levels = [(str(level), f"{count:,}") for level, count in enumerate(rays.by_level, 1)]
    kinds = [(_KINDS[kind], f"{count:,}") for kind, count in rays.by_kind.items()]
    for left, right in zip_longest(levels, kinds, fillvalue=("", "")):
        table.add_row(*left, "", *right)
    return table


_KINDS = {"camera": "camera", "mirror": "mirror (k_s)", "transmitted": "transmitted (k_t)", "total": "total reflection",
          "past": "past an outline"}


def plain_table(*headers: str, footers: Sequence[str] = ()) -> Table:
    """An empty table with one rule under its headers, and one above its footers if there are any."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE if footers else box.SIMPLE_HEAD, show_footer=bool(footers), show_edge=False, pad_edge=False,
                  padding=(0, 2, 0, 0), footer_style="none")
    for header, footer in zip_longest(headers, footers, fillvalue=""):
        table.add_column(header, footer)
    return table


def _words(effect: str) -> str:
    return effect.replace("_", " ")
