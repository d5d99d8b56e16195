"""Registries: the one list of the kinds of a family (shapes, lights, textures, backgrounds, cameras).

A new kind is a class that fulfils the family's contract, and one line in the family's list. All that files, pictures,
bounds, fits and explanations ask of a kind, they ask of its class: nothing outside a registry asks which kind a
record is.
"""

import inspect
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

from .._errors import SceneError

T = TypeVar("T")


class Registry(Generic[T]):
    """The kinds of one family, in order."""

    def __init__(self, family: str, contract: type[T], *kinds: type[T]):
        self.family, self.contract = family, contract
        self._kinds: list[type[T]] = []
        for kind in kinds:
            self.register(kind)

    def __iter__(self) -> Iterator[type[T]]:
        return iter(tuple(self._kinds))

    def __contains__(self, kind: object) -> bool:
        return kind in self._kinds

    def register(self, kind: type[T]) -> type[T]:
        """Add a kind; also a decorator. Raises `TypeError` for a class that breaks the contract or takes a name that
        is in use.
        """
        if not (isinstance(kind, type) and issubclass(kind, self.contract)) or inspect.isabstract(kind):
            missing = ", ".join(sorted(getattr(kind, "__abstractmethods__", ()))) or f"not a {self.contract.__name__}"
            raise TypeError(f"{self.family} {kind!r} breaks the contract {self.contract.__name__}: {missing}")
        taken = {name: other for other in self._kinds for name in file_names(other)}
        for name in file_names(kind):
            if name in taken:
                raise TypeError(f"{self.family} {kind.__name__}: the name {name!r} is that of {taken[name].__name__}")
        self._kinds.append(kind)
        return kind

    @contextmanager
    def including(self, kind: type[T]) -> Iterator[type[T]]:
        """The registry with one kind more, for the length of a `with` block."""
        self.register(kind)
        try:
            yield kind
        finally:
            self._kinds.remove(kind)

    def check(self, record: object, place: str) -> None:
        """Raise `SceneError` unless the record is of a kind in the list."""
        if type(record) not in self._kinds:
            known = ", ".join(kind.__name__ for kind in self._kinds)
            raise SceneError(f"{place}: a {type(record).__name__} is no {self.family}; allowed is {known}")


def file_names(kind) -> tuple[str, ...]:
    """What scene files call a kind, its own name first."""
    return (kind.TYPE, *kind.ALSO)
