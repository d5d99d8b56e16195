"""What directives of POV-Ray mean, as far as they are read."""

from collections.abc import Callable

KNOWN = ("colors.inc",)
"""Included files whose names are known without the file."""
SILENT = {"#warning", "#debug", "#render", "#statistics"}
OPENING = {"#if", "#ifdef", "#ifndef", "#switch", "#while", "#for", "#macro"}
COMPARED: dict[str, Callable[[float, float], bool]] = {
    "=": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
    "<=": lambda a, b: a <= b,
    ">=": lambda a, b: a >= b,
}
