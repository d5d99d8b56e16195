"""The words of a POV-Ray file, one after the other, with the line of each."""

import json
import re
from collections.abc import Iterator
from typing import NamedTuple

from ..._errors import SceneError

TOKEN = re.compile(
    r"(?P<space>[ \t\r\f\v]+)|(?P<line>\n)|(?P<remark>//[^\n]*)|(?P<block>/\*)|(?P<directive>\#\s*[A-Za-z]+)"
    r'|(?P<text>"(?:[^"\\\n]|\\.)*")|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<word>[A-Za-z_]\w*)'
    r"|(?P<mark><=|>=|!=|[{}()<>\[\],;+\-*/=!&|?:.])"
)
NAME = re.compile(r'\s*("(?:[^"\\]|\\.)*")')
SIZE = re.compile(r"\+W(\d{1,5})\s+\+H(\d{1,5})")


class Token(NamedTuple):
    """A word, a number, a mark, a text or a directive; at the end of the file `end`."""

    kind: str
    text: str
    line: int
    file: str

    @property
    def place(self) -> str:
        return f"{self.file}: line {self.line}"

    def error(self, what: str) -> SceneError:
        return SceneError(f"{self.place}: {what}")

    def said(self) -> str:
        return "the end of the file" if self.kind == "end" else repr(self.text[:40])


class Remarks:
    """What comments say that the writer of this program left there: names of things and sizes of pictures, by line."""

    def __init__(self):
        self.names: dict[tuple[str, int], str] = {}
        self.sizes: dict[tuple[str, int], tuple[int, int]] = {}

    def read(self, remark: str, file: str, line: int) -> None:
        if found := SIZE.search(remark):
            self.sizes[file, line] = int(found[1]), int(found[2])
        if found := NAME.match(remark):
            try:
                self.names[file, line] = json.loads(found[1])
            except ValueError:
                return


def tokens(data: bytes, file: str, remarks: Remarks) -> Iterator[Token]:
    """All of a file. Raises `SceneError` naming the line."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise SceneError(f"{file}: line {line}: this is not text; is it a POV-Ray file?")
    place, line = 0, 1
    while place < len(text):
        found = TOKEN.match(text, place)
        if found is None:
            raise SceneError(f"{file}: line {line}: {text[place]!r} means nothing here; is this a POV-Ray file?")
        kind, place = str(found.lastgroup), found.end()
        if kind == "line":
            line += 1
        elif kind == "remark":
            remarks.read(found[0][2:], file, line)
        elif kind == "block":
            begin = found.start()
            place = _after_block(text, place)
            if place < 0:
                raise SceneError(f"{file}: line {line}: a comment /* without its end */")
            line += text.count("\n", begin, place)
        elif kind != "space":
            yield Token(kind, found[0], line, file)
    yield Token("end", "", line, file)


def _after_block(text: str, place: int) -> int:
    """Where a comment ends, with those in it; -1 where it does not."""
    depth, mark = 1, re.compile(r"/\*|\*/")
    while depth:
        found = mark.search(text, place)
        if found is None:
            return -1
        depth, place = depth + (1 if found[0] == "/*" else -1), found.end()
    return place
