"""`diffwhitted parameters`: the numbers of a scene that have a name, and what a fit would make of them."""

from __future__ import annotations

import fnmatch
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ._environment import set_up
from ._options import Depth, ScenePath

if TYPE_CHECKING:
    from rich.console import Group

    from diffwhitted import Parameter, Scene

Pattern = Annotated[
    str | None,
    typer.Argument(
        metavar="PATTERN",
        show_default=False,
        help='Names to list, with wildcards in quotes: "*.k_d" lists materials, "light.*" lights, "*.*" everything. '
        "Default: everything.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON in place of the table, with every number of each.")]


def parameters(scene: ScenePath, pattern: Pattern = None, depth: Depth = None, json: Json = False) -> None:
    """List the numbers of a scene by the names that fit, derivative, explain and tradeoff take.

    \b
    What is there to say about the lights?
      diffwhitted parameters scene.toml "light.*"

    "moves" says what a change moves: nothing (weights and colours alone), patterns, shadows, or the rays. "seen" says
    whether pictures can tell anything of it at all. Bounds are those in which a fit looks unless it is told others;
    an angle u, v or roll is counted from the direction in the scene.
    """
    set_up()
    from diffwhitted import load_scene

    loaded = load_scene(scene)
    rows = parameter_rows(loaded, pattern, depth)
    if json:
        from json import dumps

        print(dumps({"scene": str(scene), "parameters": rows}, indent=2, allow_nan=False))
        return
    from rich.console import Console

    console = Console(highlight=False)
    console.print(parameter_table(rows, console.width))


def parameter_rows(scene: Scene, pattern: str | None = None, depth: int | None = None) -> list[dict[str, Any]]:
    """What is said of each parameter, as JSON values. Raises `InputError` for a pattern that matches nothing."""
    import numpy as np

    from diffwhitted import parameters as all_of
    from diffwhitted.records import shortest
    from diffwhitted.scene import maps
    from diffwhitted.tree import idle
    from fitting.problem._unknowns import list_unknowns, values_in

    rows = []
    for parameter in _chosen((*all_of(scene), *maps(scene)), scene, pattern):
        why = idle(scene, parameter, [parameter.name], depth)
        if parameter.row.kind == "texels":
            rows.append(_map_row(scene, parameter, why))
            continue
        unknowns = list_unknowns(scene, [parameter.name])
        values = values_in(scene, unknowns, scene)
        value = np.asarray(parameter.value(scene))
        held = {"value": np.vectorize(shortest, otypes=[object])(value).tolist()}
        sought = [
            {"name": u.name, "start": float(start), "unit": u.unit, "bounds": list(u.bounds)}
            for u, start in zip(unknowns, values, strict=True)
        ]
        rows.append(_row(parameter, held, why, sought))
    return rows


def _map_row(scene: Scene, parameter: Parameter, why: str | None) -> dict[str, Any]:
    """What is said of a whole picture: its shape and ends in place of its numbers."""
    from diffwhitted.records import shortest

    texels = parameter.value(scene)
    held = {"shape": list(texels.shape), "ends": [shortest(texels.min()), shortest(texels.max())]}
    return _row(parameter, held, why, [])


def _row(parameter: Parameter, held: dict[str, Any], why: str | None, unknowns: list) -> dict[str, Any]:
    """What is said of every parameter, with what it holds."""
    return {
        "name": parameter.name,
        "meaning": parameter.row.meaning,
        **held,
        "unit": parameter.row.unit,
        "allowed": parameter.row.allowed(),
        "scale": parameter.row.scale,
        "moves": parameter.row.moves,
        "seen": why is None,
        "why_not": why,
        "unknowns": unknowns,
    }


def _chosen(there, scene: Scene, pattern: str | None):
    """The parameters that a pattern names, seen or not."""
    from diffwhitted import InputError
    from fitting import FitError
    from fitting.problem._free_names import match_parameters

    if pattern in (None, "*.*"):
        return there
    named = [
        p
        for p in there
        if fnmatch.fnmatchcase(p.name, pattern) and p.name.partition(".")[0] == pattern.partition(".")[0]
    ]
    if named:
        return named
    try:
        return list(dict.fromkeys(parameter for parameter, _ in match_parameters(scene, there, pattern)[0]))
    except FitError as error:
        raise InputError(str(error).removeprefix("free: ")) from None


def parameter_table(rows: list[dict[str, Any]], width: int) -> Group:
    """The parameters as a `rich` table for a terminal `width` columns wide, and why some cannot be seen below it.

    Where it does not fit, names fold at the dot, then the bounds are left out.
    """
    from rich import box
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    from diffwhitted._errors import printable
    from fitting.telling._layout import column_widths, folded

    notes: dict[str, int] = {}
    columns: dict[str, list[str]] = {key: [] for key in ("name", "value", "unit", "bounds", "moves", "seen")}
    for row in rows:
        note = "" if row["seen"] else f"no [{notes.setdefault(row['why_not'], len(notes) + 1)}]"
        unit = "" if row["unit"] == "1" else row["unit"]
        value = _value_text(row["value"]) if "value" in row else _map_text(row)
        cells = row["name"], value, unit, _bounds_text(row), row["moves"], note or "yes"
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(printable(cell))
    short = {**columns, "name": folded(columns["name"])}
    attempts = (columns, short, {key: cells for key, cells in short.items() if key != "bounds"})
    shown, widths = attempts[-1], None
    for attempt in attempts:
        if widths := column_widths([[header, *cells] for header, cells in attempt.items()], width):
            shown = attempt
            break
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    for header, column_width in zip(shown, widths or [None] * len(shown), strict=True):
        table.add_column(header, width=column_width, overflow="fold")
    for cells in zip(*shown.values(), strict=True):
        table.add_row(*map(Text, cells))
    reasons = [f"[{number}] {printable(why)}" for why, number in notes.items()]
    return Group(table, *map(Text, ["", *reasons] if reasons else []))


def _value_text(value) -> str:
    """A number, or its components in brackets, to four digits."""
    if isinstance(value, list):
        return f"[{', '.join(map(_value_text, value))}]"
    return f"{value:.4g}"


def _map_text(row: dict[str, Any]) -> str:
    """`4 x 6 texels, 0.1 to 0.9`: rows by columns."""
    height, width, _ = row["shape"]
    low, high = row["ends"]
    return f"{height} x {width} texels, {low:.4g} to {high:.4g}"


def _bounds_text(row: dict[str, Any]) -> str:
    """`0 to 1`, `+-9` about the value, `u, v: +-45 deg`, or the widest where the components have several."""
    unknowns = row["unknowns"]
    if not unknowns:
        return row["allowed"]
    ends = list(dict.fromkeys(tuple(u["bounds"]) for u in unknowns))
    angles = [u["name"].rpartition(".")[2] for u in unknowns] if unknowns[0]["unit"] != row["unit"] else []
    before, unit = (f"{', '.join(angles)}: ", f" {unknowns[0]['unit']}") if angles else ("", "")
    halves = {f"{u['start'] - u['bounds'][0]:.4g}" for u in unknowns} | {
        f"{u['bounds'][1] - u['start']:.4g}" for u in unknowns
    }
    if len(halves) == 1 and row["scale"] == "unbounded":
        return f"{before}+-{halves.pop()}{unit}"
    if len(ends) == 1:
        return f"{before}{ends[0][0]:.4g} to {ends[0][1]:.4g}{unit}"
    low, high = min(low for low, _ in ends), max(high for _, high in ends)
    return f"{before}{low:.4g} to {high:.4g}{unit}"
