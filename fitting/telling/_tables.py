"""How a fitted coefficient reads: numbers rounded to what is known of them, and the terminal's table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from diffwhitted._errors import printable

from .._result import FitResult, FittedCoefficient
from ..planning._identification import Identification
from ._layout import column_widths, folded
from ._lengths import joined, seconds_text, stage_text

if TYPE_CHECKING:
    from rich.console import Group

_MOST_DECIMALS = 7
STATUS_WORDS = {
    "converged": "Converged",
    "misfit": "Model misfit",
    "not_converged": "Not converged",
    "not_identifiable": "Not fully determined",
    "interrupted": "Interrupted",
}


def status_sentence(result: FitResult) -> str:
    """What the status means for somebody who wants to use the numbers."""
    count = len(result.coefficients)
    missing = sum(not coefficient.identifiable for coefficient in result.coefficients)
    if result.status == "not_identifiable":
        verb = "is" if missing == 1 else "are"
        return (
            f"The solver came to rest, but {missing} of the {count} coefficients {verb} not determined by "
            "the pictures; their values are not to be relied on."
        )
    if result.status == "not_converged":
        return (
            "The solver stopped before it came to rest. The values are the best it found, not a solution, "
            "and their standard errors are not to be relied on."
        )
    if result.status == "interrupted":
        return "The fit was stopped from outside. The values are the best found until then, not a solution."
    if result.status == "misfit":
        return (
            "The solver came to rest, but the model does not fit the pictures. The values are the best of a model that "
            "is wrong somewhere; their intervals are as wide as the pictures ask for."
        )
    bounded = sum(coefficient.at_bound for coefficient in result.coefficients)
    sentence = "The solver came to rest" + (
        f", and all {count} coefficients are determined by the pictures." if count > 1 else "."
    )
    if bounded:
        sentence += f" {bounded} of them {'lies' if bounded == 1 else 'lie'} at a bound: see the remarks."
    return sentence


def further_remarks(result: FitResult) -> str:
    """The message without what the status has said already, that the fit converged."""
    first, _, rest = result.message.partition("; ")
    return rest if result.status == "converged" and first.startswith("converged") else result.message


def noise_source(result: FitResult) -> str:
    """Where the noise comes from."""
    if result.noise_given:
        return "given"
    if not math.isfinite(result.noise):
        return "cannot be estimated"
    return "at rounding level" if result.at_rounding_level else "estimated from the residual"


def rounded(value: float, standard_error: float | None) -> str:
    """`value` to the last digit its standard error leaves meaningful, or to 4 digits without one.

    The last digit shown is the last of `rounded_error`, at most seven decimals.
    """
    if not math.isfinite(value):
        return "not finite"
    if standard_error is None or not math.isfinite(standard_error) or abs(value) >= 1e7:
        return f"{value:.4g}"
    decimals = _decimals(standard_error)
    # Adding 0 turns a negative zero into a plain one.
    return f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"


def rounded_error(standard_error: float) -> str:
    """A standard error to two digits where they are at most 35, otherwise to one."""
    if not math.isfinite(standard_error):
        return "not finite"
    if standard_error == 0:
        return "0"
    if not 10**-_MOST_DECIMALS <= standard_error < 1e7:
        return f"{standard_error:.0e}"
    return rounded(standard_error, standard_error)


def _decimals(standard_error: float) -> int:
    if standard_error <= 0:
        return _MOST_DECIMALS
    mantissa, _, power = f"{standard_error:.1e}".partition("e")
    return min((1 if float(mantissa) <= 3.5 else 0) - int(power), _MOST_DECIMALS)


def value_text(coefficient: FittedCoefficient) -> str:
    """`0.1203 ± 0.0004`; the bare value where there is no standard error."""
    value = rounded(coefficient.value, coefficient.standard_error)
    if coefficient.standard_error is None:
        return value
    return f"{value} ± {rounded_error(coefficient.standard_error)}"


def interval_text(coefficient: FittedCoefficient) -> str:
    """`0.1195 to 0.1211`, rounded like the value, or half its width where both ends read alike; empty where there is
    none.
    """
    if coefficient.interval_95 is None:
        return ""
    low, high = (rounded(end, coefficient.standard_error) for end in coefficient.interval_95)
    if low != high:
        return f"{low} to {high}"
    half = (coefficient.interval_95[1] - coefficient.interval_95[0]) / 2
    return f"± {rounded_error(half)}"


def deviation_text(coefficient: FittedCoefficient, truth: float) -> str:
    """How far the value lies from the truth: `+0.25 %`; the plain difference where the truth is 0."""
    difference = coefficient.value - truth
    if not math.isfinite(difference):
        return "not finite"
    if truth == 0:
        return f"{difference:+.2g}"
    percent = 100 * difference / abs(truth)
    if abs(percent) < 0.001:
        return "< 0.001 %"
    return f"{percent:+.2g} %" if abs(percent) < 99.5 else f"{percent:+.0f} %"


def places(coefficient: FittedCoefficient, truth: float | None) -> dict[str, Any]:
    """Where value, start, truth and the ends of the interval lie between the bounds, in per cent.

    Logarithmic where the bounds are positive and a factor of 50 or more apart; what lies outside is
    put on the bound; None where there is no such number. A bound that is not finite gives way to
    the outermost of the known values.
    """
    low, high = coefficient.bounds
    known = [coefficient.value, coefficient.start, *(coefficient.interval_95 or ())]
    low, high = (low if math.isfinite(low) else min(known)), (high if math.isfinite(high) else max(known))
    logarithmic = low > 0 and high / low >= 50

    def place(value: float | None) -> float | None:
        if value is None or not math.isfinite(value) or not high > low:
            return None
        if logarithmic:
            share = math.log(max(value, low) / low) / math.log(high / low)
        else:
            share = (value - low) / (high - low)
        return round(100 * min(max(share, 0.0), 1.0), 3)

    ends = [place(end) for end in coefficient.interval_95 or ()]
    return {
        "low": f"{low:.4g}",
        "high": f"{high:.4g}",
        "logarithmic": logarithmic,
        "value": place(coefficient.value),
        "start": place(coefficient.start),
        "truth": place(truth),
        "ends": ends if len(ends) == 2 and None not in ends else None,
    }


def coefficient_table(
    result: FitResult | Identification, truth: Mapping[str, float] | None = None, width: int = 80
) -> Group:
    """The coefficients as a `rich` table for a terminal `width` columns wide, without colour, and the notes below it.

    `truth` maps names to true values; where given, they replace the column of starting values, which what is planned
    has not.
    A value in brackets is one that the pictures do not determine; the numbered notes below say why.
    Where it does not fit, long names fold at the dot, then the starts or the intervals are left out.
    """
    from rich import box
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    columns, notes = _columns(result, truth)
    columns = {header: list(map(printable, cells)) for header, cells in columns.items()}
    columns, widths = _laid_out(columns, width)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    for (header, _), column_width in zip(columns.items(), widths or [None] * len(columns), strict=True):
        left = header in ("coefficient", "unit", "95 % interval")
        table.add_column(header, justify="left" if left else "right", width=column_width, overflow="fold")
    for cells in zip(*columns.values(), strict=True):
        table.add_row(*map(Text, cells))
    return Group(table, Text(printable("\n".join(notes)))) if notes else Group(table)


def _columns(
    result: FitResult | Identification, truth: Mapping[str, float] | None
) -> tuple[dict[str, list[str]], list[str]]:
    """The cells of each column by its header, and the notes."""
    columns = {"coefficient": [], "start": [], "value": [], "unit": [], "95 % interval": [], "truth": [], "off by": []}
    notes = []
    for coefficient in result.coefficients:
        value, interval = value_text(coefficient), interval_text(coefficient)
        if coefficient.remark:
            notes.append(f"[{len(notes) + 1}] {coefficient.name}: {coefficient.remark}")
            interval = f"{interval or 'none'} [{len(notes)}]"
        true_value = (truth or {}).get(coefficient.name)
        cells = (
            coefficient.name,
            f"{coefficient.start:.4g}",
            value if coefficient.identifiable else f"({value})",
            "" if coefficient.unit == "1" else coefficient.unit,
            interval,
            "" if true_value is None else f"{true_value:.4g}",
            "" if true_value is None else deviation_text(coefficient, true_value),
        )
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(cell)
    left_out = {"truth", "off by"} if truth is None else {"start"}
    left_out |= {"start"} if isinstance(result, Identification) else set()
    left_out |= {"unit"} - {"unit" for cell in columns["unit"] if cell}
    return {header: cells for header, cells in columns.items() if header not in left_out}, notes


def _laid_out(columns: dict[str, list[str]], width: int) -> tuple[dict[str, list[str]], list[int] | None]:
    """The columns as they fit, and their widths; None where even the fewest do not, so that names break."""
    short_names = {**columns, "coefficient": folded(columns["coefficient"])}
    for attempt in (columns, short_names):
        cells = [[header, *column] for header, column in attempt.items()]
        if widths := column_widths(cells, width):
            return attempt, widths
    dropped = next((header for header in ("start", "95 % interval") if header in columns), None)
    if dropped is None:
        return short_names, None
    return _laid_out({header: column for header, column in columns.items() if header != dropped}, width)


def short(number: float) -> str:
    """A number to three digits; `unknown` where it is not finite."""
    return f"{number:.3g}" if math.isfinite(number) else "unknown"


def what_moves(result: FitResult) -> str:
    """Which of the numbers move rays, shadows or patterns, in a sentence; empty where none does."""
    said = []
    for moves in ("rays", "shadows", "patterns"):
        names = [c.name for c in result.coefficients if c.moves == moves]
        if names:
            some = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
            said.append(f"{moves} ({some})")
    return f"A change moves {'; '.join(said)}." if said else ""


def summary_lines(result: FitResult) -> list[str]:
    """What to print around the table: the status in words, the message, the error, the effort."""
    lines = [f"{STATUS_WORDS[result.status]}. {status_sentence(result)}"]
    if remarks := further_remarks(result):
        lines.append(remarks)
    lines.append(f"RMSE {short(result.rmse)} linear RGB; noise {short(result.noise)} ({noise_source(result)}).")
    if len(result.views) > 1:
        lines.append(f"Of each: {', '.join(f'{view.camera} {short(view.rmse)}' for view in result.views)}.")
    count = len(result.coefficients)
    starts = f" from the best of {result.starts_tried} starts" if result.starts_tried > 1 else ""
    steps = f"{result.steps} step{'' if result.steps == 1 else 's'}"
    lines.append(
        f"{count} coefficient{'' if count == 1 else 's'}, rank {result.rank}; {steps}{starts} in "
        f"{seconds_text(result.seconds_solve)}, after {seconds_text(result.seconds_compile)} of compiling."
    )
    if moves := what_moves(result):
        lines.append(moves)
    if len(stages := joined(result.stages)) > 1:
        lines.append("From coarse to fine: " + "; ".join(map(stage_text, stages)) + ".")
    return lines
