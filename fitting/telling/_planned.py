"""How what a fit would know reads on a terminal: the lines around its table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..planning._identification import Identification
from ._tables import rounded_error, short

if TYPE_CHECKING:
    from rich.console import Group

    from ..planning._suggest import Suggestion

_MOST_PAIRS = 5


def heading(found: Identification) -> str:
    """What the table is."""
    count = len(found.views)
    pictures = f"one picture ({found.views[0]})" if count == 1 else f"{count} pictures ({', '.join(found.views)})"
    return (
        f"What a fit of {pictures} would know if the values are those of the scene; {found.pixels:,} pixels with noise "
        f"{short(found.noise)}."
    )


def planned_lines(found: Identification) -> list[str]:
    """What the table comes to."""
    count, lines = len(found.coefficients), []
    missing = [c.name for c in found.coefficients if not c.identifiable]
    pictures = "pictures" if len(found.views) > 1 else "picture"
    if not missing:
        all_of = "the coefficient" if count == 1 else f"all {count} coefficients"
        lines.append(f"The {pictures} would determine {all_of}; rank {found.rank}.")
    else:
        lines.append(
            f"The {pictures} would not determine {', '.join(missing)} (rank {found.rank} of {count}); fix them, or add "
            "a light or a view that shows them: --suggest light, --suggest camera."
        )
    if pairs := found.strongest[:_MOST_PAIRS]:
        lines.append(
            "Almost exchangeable (correlation): " + "; ".join(f"{a} and {b} ({r:+.3f})" for a, b, r in pairs) + "."
        )
    return [*lines, *(f"{note[0].upper()}{note[1:]}." for note in found.notes)]


def suggested_lines(found: Suggestion) -> list[str]:
    """Where to put it, and what that changes in all."""
    place = ", ".join(f"{number:g}" for number in found.place)
    far = "direction = " in found.toml.partition("[[shot]]")[0]
    where = f"towards ({place})" if far else f"at ({place})"
    kind = "lamp" if found.what == "light" else "camera"
    which = f"One more {kind}" if found.added else f"The {kind} {found.name}"
    lines = [f"{which} tells most {where}, of {found.tried} places that were looked at."]
    if math.isfinite(found.gain):
        lines.append(f"The standard errors are {found.gain:.2g} times smaller there (geometric mean).")
    if (rank := found.after.rank) != found.before.rank:
        lines.append(f"The rank goes from {found.before.rank} to {rank} of {len(found.after.coefficients)}.")
    return lines


def comparison_table(found: Suggestion, width: int = 80) -> Group:
    """The standard errors before and after as a `rich` table, and the notes of those that are still not determined."""
    from rich import box
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    from diffwhitted._errors import printable

    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0), width=None)
    headers = "coefficient", "standard error", "suggested", "smaller"
    for number, header in enumerate(headers):
        table.add_column(header, justify="right" if number else "left", overflow="fold")
    notes = []
    for before, after in zip(found.before.coefficients, found.after.coefficients, strict=True):
        errors = [c.standard_error for c in (before, after)]
        cells = ["not determined" if error is None else rounded_error(error) for error in errors]
        ratio = f"{errors[0] / errors[1]:.1f} times" if errors[0] and errors[1] else ""
        table.add_row(*map(Text, (printable(after.name), *cells, ratio)))
        if not after.identifiable:
            notes.append(f"{after.name}: {after.remark}")
    return Group(table, Text(printable("\n".join(notes)))) if notes else Group(table)
