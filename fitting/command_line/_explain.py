"""`diffwhitted explain`: which effects a picture calls for, what they cost, and which rays it takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ._environment import set_up
from ._options import CameraName, Depth, Height, ScenePath, Width, chosen_camera
from ._progress import Progress, safe

if TYPE_CHECKING:
    from rich.table import Table

    from diffwhitted import Explanation, Scene
    from diffwhitted.cost import PictureCost, RayCounts
    from diffwhitted.scene import AbstractCamera

DRAWINGS = (".png", ".svg", ".pdf")

Free = Annotated[
    list[str] | None,
    typer.Option(
        "--free",
        metavar="NAME",
        show_default=False,
        help='Coefficient that a fit leaves free, so that its effect stays on at 0. Wildcards in quotes: "*.k_s".',
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON in place of the tables.")]
Measure = Annotated[
    bool,
    typer.Option(
        "--measure/--no-measure", help="Measure what each effect costs; takes some seconds for each effect that is on."
    ),
]
Maps = Annotated[
    Path | None,
    typer.Option(
        "--maps",
        metavar="IMAGE",
        show_default=False,
        help="Draw the picture with the rays, the depth and the antialiasing squares of each pixel: a PNG, SVG or "
        "PDF file.",
    ),
]


def explain(
    scene: ScenePath,
    camera: CameraName = None,
    free: Free = None,
    depth: Depth = None,
    width: Width = None,
    height: Height = None,
    json: Json = False,
    measure: Measure = True,
    maps: Maps = None,
) -> None:
    """Say which effects a scene calls for, why, what each costs, and which rays there are.

    \b
    What would a fit of all mirrors and glass cost?
      diffwhitted explain scene.toml --free "*.k_s" "*.k_t"
    Where in the picture are the rays?
      diffwhitted explain scene.toml --no-measure --maps rays.png
    """
    set_up()
    with Progress("reading") as progress:
        from diffwhitted import explain as find_out
        from diffwhitted import load_scene

        loaded = load_scene(scene)
        name, view = chosen_camera(loaded, camera)
        names = _free_names(loaded, free or [])
        if maps is not None:
            check_drawing(maps)
        progress.say("counting rays")
        explanation = find_out(
            loaded,
            view.resized(width, height),
            free=names,
            max_depth=depth,
            measure=measure,
            on_measure=lambda part: progress.say(f"measuring {part}"),
        )
        if maps is not None:
            progress.say("drawing the maps")
            draw_maps(loaded, view.resized(width, height), depth, maps)
    if json:
        from json import dumps

        print(
            dumps(
                {"scene": str(scene), "camera": name, "free": list(names)} | explanation.to_json(),
                indent=2,
                allow_nan=False,
            )
        )
    else:
        print_explanation(explanation, f"{scene}, camera {name}")


def check_drawing(path: Path) -> None:
    """Raise an `InputError` before any work where no drawing can be written."""
    from diffwhitted.image import check_place
    from fitting.telling._outputs import OutputError

    if path.suffix.lower() not in DRAWINGS:
        raise OutputError(f"cannot write the extension {path.suffix!r} of {path}; allowed is {', '.join(DRAWINGS)}")
    check_place(path)


def draw_maps(scene: Scene, camera: AbstractCamera, depth: int | None, path: Path) -> None:
    import numpy as np

    from diffwhitted import ray_maps, render
    from fitting.telling._maps_plot import write_maps

    picture = np.asarray(render(scene, camera, max_depth=depth))
    write_maps(ray_maps(scene, camera, max_depth=depth), picture, path)


def _free_names(scene: Scene, patterns: list[str]) -> tuple[str, ...]:
    if not patterns:
        return ()
    from fitting.problem._free_names import free_parameters, whole_names

    return whole_names(scene, free_parameters(scene, patterns)[0])


def print_explanation(explanation: Explanation, title: str) -> None:
    """Tables of effects and rays that read at 80 columns, without colour."""
    from rich.console import Console

    console, rays = Console(highlight=False), explanation.rays
    sentences = [
        f"{rays.background:,} of the rays ({rays.background / rays.total:.0%}) met nothing.",
        f"Beside them, {rays.shadow:,} shadow rays went from lit points to lights.",
    ]
    if cut := sum(rays.cut_off.values()):
        sentences.append(
            f"{cut:,} more lie past depth {explanation.max_depth} and bring no light; a larger --depth follows them."
        )
    console.print(
        safe(f"{title}: {explanation.width} x {explanation.height} pixels, depth {explanation.max_depth}"), markup=False
    )
    cost = explanation.cost
    costs = (_cost_table(explanation, cost), _about_cost(cost)) if cost is not None else ()
    tests = (_search_table(explanation), _ABOUT_TESTS) if explanation.search else ()
    for part in (_effect_table(explanation), *costs, _ray_table(explanation.rays), " ".join(sentences), *tests):
        console.print()
        console.print(part)


def _effect_table(explanation: Explanation) -> Table:
    from rich.text import Text

    table = plain_table("effect", "", "why")
    for effect in explanation.effects:
        table.add_row(_words(effect.name), "on" if effect.on else "off", Text(safe(effect.why)))
    return table


def _cost_table(explanation: Explanation, whole: PictureCost) -> Table:
    """What the picture gains without each effect, the dearest first."""
    table = plain_table("without", "time", "compile", "rays")
    for column in table.columns[1:]:
        column.justify = "right"
    table.add_row(
        "(the picture)", f"{1000 * whole.seconds:.3g} ms", f"{whole.seconds_compile:.2g} CPU s", f"{whole.rays:,}"
    )
    measured = [(effect.name, effect.cost) for effect in explanation.effects if effect.cost is not None]
    for name, cost in sorted(measured, key=lambda pair: -pair[1].share):
        table.add_row(
            _words(name),
            "below noise" if cost.below_noise else f"{-cost.share:+.0%}",
            f"{-cost.compile_share:+.0%}",
            f"{-cost.rays:+,}" if cost.rays else "",
        )
    return table


def _about_cost(cost: PictureCost) -> str:
    parts = ", ".join(f"{name} {share:.0%}" for name, share in asdict(cost.work).items())
    return (
        f"Of the time: {parts}. Overhead is the way along known rays, intersection the search for what rays and "
        "shadow rays meet, shading the light. What two effects share counts in both. Each was compiled once: less "
        "than a fifth is noise there."
    )


def _ray_table(rays: RayCounts) -> Table:
    table = plain_table(
        "rays of level",
        "count",
        "",
        "of kind",
        "count",
        footers=("all", f"{rays.total:,}", "", "all", f"{rays.total:,}"),
    )
    for number in (1, 4):
        table.columns[number].justify = "right"
    levels = [(str(level), f"{count:,}") for level, count in enumerate(rays.by_level, 1)]
    kinds = [(_KINDS[kind], f"{count:,}") for kind, count in rays.by_kind.items()]
    for left, right in zip_longest(levels, kinds, fillvalue=("", "")):
        table.add_row(*left, "", *right)
    return table


def _search_table(explanation: Explanation) -> Table:
    """What a ray of each kind tests."""
    table = plain_table("tests of a ray", "boxes", "surfaces")
    for column in table.columns[1:]:
        column.justify = "right"
    for kind, tests in explanation.search.items():
        table.add_row(_KINDS[kind], f"{tests.boxes:.1f}", f"{tests.surfaces:.1f}")
    return table


_ABOUT_TESTS = (
    "Means: boxes of the tree, and surfaces in those that a ray comes to; kinds of surfaces without a tree are asked "
    "one by one and count all. Of large pictures some rays of each kind were counted."
)
_KINDS = {
    "camera": "camera",
    "mirror": "mirror (k_s)",
    "transmitted": "transmitted (k_t)",
    "total": "total reflection",
    "past": "past a silhouette",
    "shadow": "to a light",
}


def plain_table(*headers: str, footers: Sequence[str] = ()) -> Table:
    """An empty table with one rule under its headers, and one above its footers if there are any."""
    from rich import box
    from rich.table import Table

    table = Table(
        box=box.SIMPLE if footers else box.SIMPLE_HEAD,
        show_footer=bool(footers),
        show_edge=False,
        pad_edge=False,
        padding=(0, 2, 0, 0),
        footer_style="none",
    )
    for header, footer in zip_longest(headers, footers, fillvalue=""):
        table.add_column(header, footer)
    return table


def _words(effect: str) -> str:
    return effect.replace("_", " ")
