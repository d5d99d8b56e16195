"""Names of a package that are imported when they are first asked for: not every user reads files."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazily(package: str, homes: Mapping[Any, str]) -> Callable[[str], object]:
    """A `__getattr__` for the package, which finds its names in the modules that `homes` says."""

    def find(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{homes[name]}"), name)

    return find
