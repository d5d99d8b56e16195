"""XML of Mitsuba as tags that know their lines, with `$names` and included files put in.

Neither entities nor a DOCTYPE are read, so that nothing grows beyond the size of the file.
"""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

import numpy as np

from ..._errors import SceneError
from .._numbers import usable

MOST_TAGS = 500_000
DEEPEST = 64
MOST_INCLUDED = 64
LARGEST_INCLUDED = 16 * 2**20
"""Bytes of all included files."""
LONGEST_VALUE = 100_000


@dataclass(eq=False)
class Tag:
    """One element."""

    word: str
    attributes: dict[str, str]
    place: str
    """File and line."""
    children: list["Tag"] = field(default_factory=list)

    @property
    def name(self) -> str:
        return self.attributes.get("name", "")

    @property
    def type(self) -> str:
        return self.attributes.get("type", "")

    def error(self, what: str) -> SceneError:
        return SceneError(f"{self.place}: {what}")

    def named(self, name: str, *words: str) -> "Tag | None":
        """The child of a name, of one of the words if any are given."""
        found = [tag for tag in self.children if tag.name == name and (not words or tag.word in words)]
        return found[-1] if found else None

    def of(self, *words: str) -> Iterator["Tag"]:
        return (tag for tag in self.children if tag.word in words)

    def text(self, name: str, default: str) -> str:
        tag = self.named(name, "string")
        return default if tag is None else tag.attributes.get("value", default)

    def number(self, name: str, default: float) -> float:
        tag = self.named(name, "float", "integer")
        return default if tag is None else tag.numbers("value", 1)[0]

    def truth(self, name: str, default: bool) -> bool:
        tag = self.named(name, "boolean")
        return default if tag is None else tag.attributes.get("value", "").lower() == "true"

    def whole(self, name: str, default: int, low: int, high: int) -> int:
        found = self.number(name, default)
        if not (float(found).is_integer() and low <= found <= high):
            raise self.error(f"{name} = {found:g}; allowed is a whole number from {low} to {high}")
        return int(found)

    def numbers(self, key: str, *counts: int) -> list[float]:
        """The numbers of an attribute: as many as one of `counts`."""
        stated = self.attributes.get(key, "")
        words = stated.replace(",", " ").split()
        if len(words) not in counts:
            allowed = " or ".join(map(str, counts))
            raise self.error(f"{key} = {stated[:40]!r} of <{self.word}> has {len(words)} numbers; allowed is {allowed}")
        found = []
        for word in words:
            number = usable(word)
            if number is None:
                raise self.error(
                    f"{word[:20]!r} in {key} of <{self.word}> is no number that can be used; allowed is one up to 1e30"
                )
            found.append(number)
        return found

    def point(self) -> np.ndarray:
        """(3,), of `value`, or of x, y and z."""
        if "value" in self.attributes:
            return np.asarray(self.numbers("value", 3))
        return np.asarray([self.numbers(key, 1)[0] if key in self.attributes else 0.0 for key in "xyz"])


def read_tags(data: bytes, source: str) -> Tag:
    """The element <scene>. Raises `SceneError` naming the line."""
    return _Reader(source).whole(data)


class _Reader:
    """What is known while files are read."""

    def __init__(self, source: str):
        self._source, self._folder = source, Path(source).parent
        self._values: dict[str, str] = {}
        self._count = self._included = self._bytes = 0

    def whole(self, data: bytes) -> Tag:
        root = self._tags(data, self._source)
        if root.word != "scene":
            raise root.error(f"this is <{root.word[:40]}>; allowed is <scene> of Mitsuba 3")
        return self._resolved(root, 0)

    def _tags(self, data: bytes, source: str) -> Tag:
        parser, open_tags, found, said = expat.ParserCreate(), [], [], []

        def fail(what: str):
            raise SceneError(f"{source}: line {parser.CurrentLineNumber}: {what}")

        def begin(word: str, attributes: dict[str, str]):
            self._count += 1
            if self._count > MOST_TAGS:
                fail(f"more than {MOST_TAGS:,} elements; allowed is fewer")
            if len(open_tags) >= DEEPEST:
                fail(f"elements within elements more than {DEEPEST} deep; allowed is fewer")
            if word == "shape" and said:
                attributes.setdefault("id", said[-1])
            said.clear()
            tag = Tag(word, attributes, f"{source}: line {parser.CurrentLineNumber}")
            (open_tags[-1].children if open_tags else found).append(tag)
            open_tags.append(tag)

        parser.StartElementHandler, parser.EndElementHandler = begin, lambda word: open_tags.pop()
        parser.CommentHandler = lambda remark: said.extend(_name_in(remark))
        parser.StartDoctypeDeclHandler = lambda *_: fail("a DOCTYPE is not read; allowed is XML without one")
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            problem = expat.errors.messages[error.code]
            raise SceneError(f"{source}: line {error.lineno}: broken XML: {problem}") from None
        except (ValueError, LookupError) as error:
            raise SceneError(f"{source}: broken XML: {error}") from None
        return found[0]

    def _resolved(self, tag: Tag, depth: int) -> Tag:
        """With values for `$names`, and what an <include> stands for."""
        children: list[Tag] = []
        for child in tag.children:
            child.attributes = {key: self._replaced(child, value) for key, value in child.attributes.items()}
            if child.word == "default":
                self._values.setdefault(child.name, child.attributes.get("value", ""))
            elif child.word == "include":
                children += self._include(child, depth)
            else:
                children.append(self._resolved(child, depth))
        tag.children = children
        return tag

    def _replaced(self, tag: Tag, value: str) -> str:
        def known(match) -> str:
            if match[1] not in self._values:
                raise tag.error(f"${match[1]} has no value; write <default name={match[1]!r} value=.../> above it")
            return self._values[match[1]]

        found = re.sub(r"\$(\w+)", known, value) if "$" in value else value
        if len(found) > LONGEST_VALUE:
            raise tag.error(f"a value of more than {LONGEST_VALUE:,} letters; allowed is less")
        return found

    def _include(self, tag: Tag, depth: int) -> list[Tag]:
        stated = tag.attributes.get("filename", "")
        self._included += 1
        if depth > DEEPEST or self._included > MOST_INCLUDED:
            raise tag.error(f"more than {MOST_INCLUDED} included files; does one include itself?")
        path = file_beside(tag, stated, self._folder)
        try:
            data = path.read_bytes() if path.is_file() else None
        except OSError:
            data = None
        if data is None:
            raise tag.error(f"include {stated[:80]!r}: there is no such file in the folder of the scene")
        self._bytes += len(data)
        if self._bytes > LARGEST_INCLUDED:
            raise tag.error(f"included files of more than {LARGEST_INCLUDED >> 20} MiB; allowed is less")
        return self._resolved(self._tags(data, str(path.name)), depth + 1).children


def _name_in(remark: str) -> list[str]:
    """What the writer of this program calls the shape below: a text in quotes."""
    try:
        name = json.loads(remark)
    except ValueError:
        return []
    return [name] if isinstance(name, str) else []


def file_beside(tag: Tag, stated: str, folder: Path) -> Path:
    """A file that a tag names. Raises `SceneError` unless it would be within the folder."""
    try:
        path = (folder / stated).resolve()
    except (OSError, ValueError):
        path = Path("/")
    if not stated or not path.is_relative_to(folder.resolve()):
        raise tag.error(f"file {stated[:80]!r} is not within the folder of the scene; allowed is one that is")
    return path
