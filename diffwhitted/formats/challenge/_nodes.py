"""YAML as nodes that know their lines. Nothing is constructed: an alias is the very node of its anchor, so that a file
of many aliases is as small as it looks.
"""

from dataclasses import dataclass

import numpy as np
import yaml

from ..._errors import SceneError
from .._numbers import usable

LARGEST_FILE = 4 * 2**20
"""Bytes; PyYAML takes a minute for them."""


@dataclass(frozen=True, eq=False)
class Entry:
    """One node, and what messages call its file."""

    node: yaml.Node
    source: str

    def error(self, what: str) -> SceneError:
        return SceneError(f"{self.place()}: {what}")

    def place(self) -> str:
        return f"{self.source}: line {self.node.start_mark.line + 1}"

    @property
    def is_list(self) -> bool:
        return isinstance(self.node, yaml.SequenceNode)

    @property
    def is_table(self) -> bool:
        return isinstance(self.node, yaml.MappingNode)

    def entries(self, what: str) -> list["Entry"]:
        """Those of a list."""
        if not isinstance(self.node, yaml.SequenceNode):
            raise self.error(f"{what} is no list; allowed is a list, in [...] or of lines that begin with a dash")
        return [Entry(node, self.source) for node in self.node.value]

    def table(self, what: str) -> dict[str, "Entry"]:
        """The entries by key."""
        if not isinstance(self.node, yaml.MappingNode):
            raise self.error(f"{what} has no keys; allowed are lines such as `key: value`")
        found: dict[str, Entry] = {}
        for key, value in self.node.value:
            word = Entry(key, self.source).word("a key")
            if word == "<<":
                raise Entry(key, self.source).error("merged keys (<<) are not read; allowed is define with extend")
            if word in found:
                raise Entry(key, self.source).error(f"{word} is stated twice")
            found[word] = Entry(value, self.source)
        return found

    def word(self, what: str) -> str:
        if not isinstance(self.node, yaml.ScalarNode):
            raise self.error(f"{what} is no word")
        return str(self.node.value)

    def truth(self, what: str) -> bool:
        word = self.word(what).lower()
        if word not in ("true", "false", "yes", "no"):
            raise self.error(f"{what} = {word[:20]}; allowed is true or false")
        return word in ("true", "yes")

    def number(self, what: str) -> float:
        word = self.word(what)
        found = usable(word)
        if found is None:
            raise self.error(f"{what} = {word[:20]!r} is no number that can be used; allowed is one up to 1e30")
        return found

    def numbers(self, what: str, count: int = 3) -> np.ndarray:
        found = self.entries(what)
        if len(found) != count:
            raise self.error(f"{what} has {len(found)} numbers; allowed is {count}")
        return np.asarray([one.number(what) for one in found])


def read_nodes(data: bytes, source: str) -> Entry:
    """The whole file. Raises `SceneError` naming the line."""
    if len(data) > LARGEST_FILE:
        raise SceneError(f"{source}: more than {LARGEST_FILE >> 20} MiB; allowed is less. Is this a scene file?")
    try:
        node = yaml.compose(data.decode("utf-8-sig"), Loader=yaml.SafeLoader)
    except UnicodeDecodeError:
        raise SceneError(f"{source}: this is not text; is it a YAML file?") from None
    except RecursionError:
        raise SceneError(f"{source}: lists within lists too deep to be read; allowed is fewer") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark else ""
        problem = getattr(error, "problem", None) or str(error).partition("\n")[0]
        raise SceneError(f"{source}: {where}broken YAML: {problem}") from None
    if node is None:
        raise SceneError(f"{source}: the file is empty; allowed is a list of `- add: ...` and `- define: ...`")
    return Entry(node, source)
