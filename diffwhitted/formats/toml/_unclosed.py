"""Where in a broken TOML text an array began that nothing closes."""

import re
from collections.abc import Sequence

NEXT = re.compile(r"\s*(\w[\w-]*\s*=|\[\[?\s*[A-Za-z][\w-]*\s*\]\]?\s*(#.*)?$)")
"""A line that begins a key or a table, which no array holds."""
BASIC, LITERAL = r'"(?:[^"\\]|\\.)*"', r"'[^']*'"
ASIDE = re.compile(rf"{BASIC}|{LITERAL}|#.*")
"""Text in quotes, and comments: their brackets are no brackets."""


def unclosed_array(lines: Sequence[str], fault: int) -> int | None:
    """The number of the line where the array began in which the reader was at the line `fault` (both from 1), if that
    line, or the end of the text, shows that it should have been closed before; None if not.
    """
    if fault <= len(lines) and not NEXT.match(lines[fault - 1]) and any(line.strip() for line in lines[fault:]):
        return None
    opened = []
    for number, line in enumerate(lines[: fault - 1], 1):
        plain = ASIDE.sub("", line)
        # Outside of arrays only what follows a key may begin one: other brackets are those of tables.
        for bracket in plain if opened else plain.partition("=")[2]:
            if bracket == "[":
                opened.append(number)
            elif bracket == "]" and opened:
                opened.pop()
    return opened[0] if opened else None
