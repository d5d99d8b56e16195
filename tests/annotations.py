"""The type checker that `conftest.py` hooks into both packages: annotations hold, shapes of arrays among them.

Ints and NumPy's numbers count as the numbers that they are. Public functions are left out, and those that they hand a
user's words to: they check what they are given themselves, with errors that name the argument, and tests give them what
they must refuse.
"""

import ast
from collections.abc import Callable
from pathlib import Path

import numpy as np
from beartype import BeartypeConf, FrozenDict, beartype

ROOT = Path(__file__).parents[1]
PACKAGES = ("diffwhitted", "fitting")
CHECKING = ("Asked", "diffwhitted", "list_unknowns", "make_plan", "start_values")
"""Behind the doors: what checks a user's words itself or passes them on, and a callback whose hint is an alias."""


def public_names(package: str) -> list[str]:
    """`__all__` of a package, read without importing it."""
    for statement in ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == "__all__":
            return ast.literal_eval(statement.value)
    raise AssertionError(f"{package} has no __all__")


DOORS = {*CHECKING, *(name for package in (*PACKAGES, "diffwhitted/image") for name in public_names(package))}
NUMBERS = {bool: bool | np.bool_, int: int | np.integer, float: float | int | np.integer | np.floating}
_check = beartype(conf=BeartypeConf(hint_overrides=FrozenDict(NUMBERS)))


def checked(function: Callable) -> Callable:
    """The function with its arguments and its result checked; a door, or a method of one, as it is."""
    if function.__qualname__.split(".")[0] in DOORS or _is_of_openimageio(function):
        return function
    return _check(function)


def _is_of_openimageio(function: Callable) -> bool:
    """Its classes must not outlive it: it says so on the terminal, at length."""
    return any(getattr(hint, "__module__", "").startswith("OpenImageIO") for hint in function.__annotations__.values())
