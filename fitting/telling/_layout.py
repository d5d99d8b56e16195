"""Widths of the columns of a table in the terminal, such that no number and no name breaks inside."""

from collections.abc import Sequence

GAP = 2
"""Columns of the terminal between two columns of a table."""


def folded(names: Sequence[str]) -> list[str]:
    """The names, of which the long ones fold at the dot: the coefficient goes on a line of its own."""
    parts = [_folded(name) for name in names]
    longest = max((len(line) for part in parts for line in part.splitlines()), default=0)
    return [name if len(name) <= longest else part for name, part in zip(names, parts, strict=True)]


def _folded(name: str) -> str:
    parts = name.split(".")
    tail = 2 if len(parts) > 2 and len(parts[-1]) == 1 else 1
    return f"{'.'.join(parts[:-tail])}\n.{'.'.join(parts[-tail:])}" if len(parts) > 1 else name


def column_widths(columns: Sequence[Sequence[str]], width: int) -> list[int] | None:
    """A width for each column of cells so that all of them fit, narrowed where the most can give; None if they cannot.

    A column can give until its longest word: it wraps at spaces and ends of lines alone.
    """
    widths = [max(len(line) for cell in column for line in cell.splitlines() or [""]) for column in columns]
    least = [max((len(word) for cell in column for word in cell.split()), default=0) for column in columns]
    room = width - GAP * (len(columns) - 1)
    while sum(widths) > room:
        most = max(range(len(widths)), key=lambda i: widths[i] - least[i])
        if widths[most] == least[most]:
            return None
        widths[most] -= 1
    return widths
