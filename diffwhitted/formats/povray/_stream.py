"""The words of a POV-Ray file after its directives: #declare, #include, #ifdef, #switch and so on."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ._directives import COMPARED, KNOWN, OPENING, SILENT
from ._tokens import Remarks, Token, tokens

DEEPEST = 80
"""Of braces, brackets and calls within each other."""
MOST_INCLUDED = 32
LARGEST_INCLUDED = 16 * 2**20
"""Bytes of all included files."""


class Stream:
    """One token after the other. What is declared is in `values`."""

    def __init__(self, data: bytes, source: str):
        self.source, self.remarks = source, Remarks()
        self.values: dict[str, Any] = {}
        self.spots: dict[str, tuple[str, int]] = {}
        self.includes: set[str] = set()
        self._folder, self._files = Path(source).parent, [tokens(data, source, self.remarks)]
        self._ahead: Token | None = None
        self._held: Token | None = None
        self._last = Token("end", "", 1, source)
        self._open: list[str] = []
        self._depth = self._included = self._bytes = 0
        self.declared: Callable[[], Any] = lambda: None
        """Reads the value of a #declare."""
        self.default: Callable[[], None] = lambda: None
        """Reads the braces of a #default."""
        self.left_out: Callable[[Token], None] = lambda token: None
        """Reads a word in a case that is not taken, if it wants to."""

    def peek(self) -> Token:
        while self._ahead is None:
            token = self._raw()
            if token.kind == "directive":
                self._directive(token)
            else:
                self._ahead = token
        return self._ahead

    def take(self) -> Token:
        token = self.peek()
        self._ahead, self._last = None, token
        return token

    def give_back(self, token: Token) -> None:
        """Let a token that was just taken be the next one."""
        self._ahead = token

    def accept(self, *texts: str) -> Token | None:
        """The next token, if it is one of these words or marks."""
        token = self.peek()
        return self.take() if token.text in texts and token.kind in ("word", "mark") else None

    def accept_here(self, *texts: str) -> Token | None:
        """The same, before any directive: a #declare must not be read while the value of another is."""
        if self._ahead is None:
            self._held = self._raw()
            if self._held.text not in texts:
                return None
        return self.accept(*texts)

    def expect(self, text: str, of: str) -> Token:
        token = self.take()
        if token.text != text or token.kind == "text":
            raise token.error(f"{token.said()} in {of}; allowed is {text}")
        return token

    def comma(self) -> None:
        self.accept(",")

    def last(self) -> Token:
        return self._last

    @contextmanager
    def deeper(self, token: Token) -> Iterator[None]:
        """One level more, for the length of a `with` block."""
        self._depth += 1
        if self._depth > DEEPEST:
            raise token.error(f"braces within braces more than {DEEPEST} deep; allowed is fewer")
        try:
            yield
        finally:
            self._depth -= 1

    def block(self, of: Token) -> Iterator[Token]:
        """The words within braces, each of which is to be read together with what belongs to it."""
        self.expect("{", of.text)
        with self.deeper(of):
            while not self.accept("}"):
                token = self.take()
                if token.kind == "end":
                    raise of.error(f"{of.text} {{ has no end; allowed is a }} for each {{")
                yield token

    def skip_block(self, of: Token) -> None:
        """Leave out braces and all in them."""
        self.expect("{", of.text)
        depth = 1
        while depth:
            token = self.take()
            if token.kind == "end":
                raise of.error(f"{of.text} {{ has no end; allowed is a }} for each {{")
            depth += {"{": 1, "}": -1}.get(token.text, 0) if token.kind == "mark" else 0

    def spot(self) -> tuple[str, int]:
        """File and line of what was read last; a comment there may hold a name."""
        return self._last.file, self._last.line

    def _raw(self) -> Token:
        if self._held is not None:
            token, self._held = self._held, None
            return token
        while True:
            try:
                token = next(self._files[-1])
            except StopIteration:
                token = Token("end", "", self._last.line, self._last.file)
            if token.kind != "end" or len(self._files) == 1:
                if token.kind == "end" and self._open:
                    raise token.error(f"{self._open[-1]} has no #end")
                return token
            self._files.pop()

    def _directive(self, token: Token) -> None:
        word = "#" + token.text[1:].strip()
        if word in ("#declare", "#local"):
            self._declare()
        elif word == "#include":
            self._include(token)
        elif word in ("#ifdef", "#ifndef"):
            self.expect("(", word)
            known = self._raw().text in self.values
            self.expect(")", word)
            self._branch(word, known == (word == "#ifdef"), token)
        elif word == "#if":
            self._branch(word, self._condition(word), token)
        elif word == "#switch":
            self._switch(token)
        elif word in ("#else", "#elseif") and self._open or word == "#break" and self._open[-1:] == ["#switch"]:
            self._skip(token, ends=("#end",))
            self._open.pop()
        elif word in ("#case", "#range") and self._open and self._open[-1] == "#switch":
            self._condition(word)
        elif word == "#end" and self._open:
            self._open.pop()
        elif word == "#version":
            self.number(token)
            self.accept(";")
        elif word == "#default":
            self.default()
        elif word == "#undef":
            self.values.pop(self.take().text, None)
        elif word in SILENT:
            self.take()
        else:
            raise token.error(
                f"{word} is not read; allowed are #declare, #local, #include, #if, #ifdef, #ifndef, #switch, #default "
                "and #version. Let POV-Ray's own scene be written without it"
            )

    def _declare(self) -> None:
        name = self.take()
        if name.kind != "word":
            raise name.error(f"{name.said()} is no name that can be declared")
        if self.accept("["):
            raise name.error(f"array {name.text} is not read; allowed are numbers, vectors, colours, textures, shapes")
        self.expect("=", f"#declare {name.text}")
        self.spots[name.text] = self.spot()
        with self.deeper(name):
            self.values[name.text] = self.declared()
        self.accept(";")

    def _include(self, token: Token) -> None:
        stated = self._raw()
        name = stated.text.strip('"')
        self._included += 1
        if stated.kind != "text" or self._included > MOST_INCLUDED:
            raise token.error(f"#include {stated.said()}: no name of a file, or more than {MOST_INCLUDED} files")
        if name in KNOWN:
            self.includes.add(name)
            return
        folder = self._folder.resolve()
        try:
            path = (folder / name).resolve()
            data = path.read_bytes() if path.is_relative_to(folder) and path.is_file() else None
        except (OSError, ValueError):
            data = None
        if data is None:
            raise token.error(
                f"#include {name[:80]!r}: there is no such file in the folder of the scene; allowed is one that is "
                f"there, and {', '.join(KNOWN)}"
            )
        self._bytes += len(data)
        if self._bytes > LARGEST_INCLUDED:
            raise token.error(f"included files of more than {LARGEST_INCLUDED >> 20} MiB; allowed is less")
        self._files.append(tokens(data, path.name, self.remarks))

    def number(self, token: Token) -> float:
        """A number of its own, as of a version."""
        found = self.take()
        if found.kind != "number":
            raise found.error(f"{found.said()} after {token.text}; allowed is a number")
        return float(found.text)

    expression: Callable[[], Any]
    """Reads a number or a vector."""

    def _condition(self, word: str) -> bool | np.ndarray:
        """Of #if, or the values of #case and #range."""
        self.expect("(", word)
        first = self.expression()
        if sign := self.accept("=", "!=", "<", ">", "<=", ">="):
            second = self.expression()
            first = bool(COMPARED[sign.text](np.ravel(first)[0], np.ravel(second)[0]))
        elif self.accept(","):
            first = np.asarray([np.ravel(first)[0], np.ravel(self.expression())[0]])
        self.expect(")", word)
        return np.ravel(np.asarray(first, float)) if word in ("#switch", "#case", "#range") else bool(np.any(first))

    def _branch(self, word: str, taken: bool | np.ndarray, token: Token) -> None:
        """Go on where a condition holds, else after the #else or the #end."""
        if taken:
            self._open.append(word)
            return
        stop = self._skip(token, ends=("#else", "#elseif", "#end"))
        if stop == "#else":
            self._open.append(word)
        elif stop == "#elseif":
            self._branch(word, self._condition("#if"), token)

    def _switch(self, token: Token) -> None:
        value = np.ravel(self._condition("#switch"))[0]
        while (stop := self._skip(token, ends=("#case", "#range", "#else", "#end"))) != "#end":
            if stop == "#else":
                break
            limits = np.ravel(self._condition(stop))
            if limits[0] <= value <= limits[-1]:
                break
        else:
            return
        self._open.append("#switch")

    def _skip(self, of: Token, ends: tuple[str, ...]) -> str:
        """Leave out what follows up to one of these directives at the same depth; which one it is."""
        depth = 0
        if self._ahead is not None:
            self._ahead = None
        while True:
            token = self._raw()
            if token.kind == "end":
                raise of.error(f"{of.text} has no #end")
            if token.kind != "directive":
                if not depth:
                    self._offer(token)
                continue
            word = "#" + token.text[1:].strip()
            if depth == 0 and word in ends:
                return word
            depth += 1 if word in OPENING else -1 if word == "#end" else 0

    def _offer(self, token: Token) -> None:
        """Let a camera of another case be read."""
        if token.text == "camera" and token.kind == "word":
            self._ahead = token
            self.left_out(token)
