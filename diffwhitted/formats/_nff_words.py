"""The lines of an NFF file, their numbers, and what messages say of them."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from .._errors import SceneError
from ._numbers import usable

MOST_CORNERS = 512
"""Of one polygon."""
LONGEST_LINE = 4096


@dataclass(frozen=True)
class Line:
    """A line that is no comment: its number from 1, its first word, and the others."""

    number: int
    word: str
    rest: tuple[str, ...]

    def said(self) -> str:
        return repr(self.word if len(self.word) <= 20 else f"{self.word[:20]}...")


class Words:
    """The file, line by line. Every error is a `SceneError` that names the file and the line."""

    def __init__(self, data: bytes, source: str):
        self.source = source
        self._lines = self._split(data)
        self._next: Line | None = None
        self._last = 0

    def lines(self) -> Iterator[Line]:
        """Those that are left; a method below may take some of them meanwhile."""
        while (line := self._take()) is not None:
            yield line

    def parts(self, known: Collection[str], of: Line) -> Iterator[Line]:
        """The lines that follow and begin with one of the known words."""
        while (line := self._take()) is not None:
            if line.word not in known:
                self._next = line
                return
            yield line

    def numbers(self, line: Line, *counts: int) -> list[float]:
        """The numbers after the first word: as many as one of `counts`."""
        if len(line.rest) not in counts:
            allowed = " or ".join(map(str, counts))
            raise self.error(line, f"{line.word} has {len(line.rest)} numbers; allowed is {allowed}")
        return self._read(line, line.rest)

    def count(self, line: Line) -> int:
        """The one whole number after p or pp: of corners."""
        (number,) = self.numbers(line, 1)
        if not (number.is_integer() and 3 <= number <= MOST_CORNERS):
            raise self.error(
                line, f"{line.word} {line.rest[0][:20]}; allowed is a whole number of corners from 3 to {MOST_CORNERS}"
            )
        return int(number)

    def words_below(self, line: Line, rows: int, columns: int) -> list[list[float]]:
        """The numbers of the next `rows` lines, `columns` each."""
        if rows and line.word == "c" and line.rest:
            raise self.error(line, "c stands alone on its line; base and apex follow on lines of their own")
        found = []
        for number in range(rows):
            row = self._take()
            if row is None:
                raise self.error(
                    line, f"the file ends after {number} of {rows} lines of numbers that {line.word} needs"
                )
            words = (row.word, *row.rest)
            if len(words) != columns:
                raise self.error(
                    row, f"{len(words)} numbers; allowed is {columns}, for {line.word} of line {line.number}"
                )
            found.append(self._read(row, words))
        return found

    def place(self, line: Line, what: str) -> str:
        """What messages of a record call it."""
        return f"{self.source}: line {line.number}: {what}"

    def error(self, line: Line, what: str) -> SceneError:
        return SceneError(f"{self.source}: line {line.number}: {what}")

    def _read(self, line: Line, words: Collection[str]) -> list[float]:
        numbers = []
        for word in words:
            number = usable(word)
            if number is None:
                raise self.error(line, f"{word[:20]!r} is no number that can be used; allowed is one up to 1e30")
            numbers.append(number)
        return numbers

    def _take(self) -> Line | None:
        if self._next is not None:
            line, self._next = self._next, None
            return line
        return next(self._lines, None)

    def _split(self, data: bytes) -> Iterator[Line]:
        begin, number = 0, 0
        while begin < len(data):
            end = data.find(b"\n", begin)
            end, number = len(data) if end < 0 else end, number + 1
            if end - begin > LONGEST_LINE and not data[begin : begin + 1] == b"#":
                raise SceneError(
                    f"{self.source}: line {number}: {end - begin:,} bytes long; allowed is {LONGEST_LINE:,}. Is this "
                    "an NFF file?"
                )
            content = data[begin:end].partition(b"#")[0]
            begin = end + 1
            try:
                word, *rest = content.decode("utf-8-sig" if number == 1 else "utf-8").split()
            except UnicodeDecodeError:
                raise SceneError(f"{self.source}: line {number}: this is not text; is it an NFF file?") from None
            except ValueError:
                continue
            yield Line(number, word, tuple(rest))
