"""What a person sees while they wait: one line on the terminal that is gone afterwards."""

from __future__ import annotations

import time
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fitting import FitStep

ENOUGH_TO_TELL = 0.2
"""The part of the work after which the time that is left is foretold."""


def say(text: str, *, file: Any | None = None) -> None:
    """Print a line that may hold names of files."""
    print(safe(text), file=file)


def safe(text: str) -> str:
    """The text with what would steer the terminal written out."""
    if text.isprintable():
        return text
    from diffwhitted._errors import printable

    return printable(text)


class Progress:
    """A line on stderr with a clock; nothing at all where stderr is no terminal or `quiet`."""

    def __init__(self, text: str, *, quiet: bool = False):
        from rich.console import Console
        from rich.live import Live

        console = Console(stderr=True)
        self._text, self._begun, self._starts = text, time.perf_counter(), 0
        shown = console.is_terminal and not quiet
        self._console, self._quiet = console, quiet
        self._live = (
            Live(console=console, get_renderable=self._line, refresh_per_second=8, transient=True) if shown else None
        )

    def __enter__(self) -> Progress:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def say(self, text: str) -> None:
        """Replace the text of the line."""
        self._text = text

    def part(self, text: str, done: float) -> None:
        """Replace the text, and say what time is left where a part `done` of the work took the time so far."""
        passed = time.perf_counter() - self._begun
        left = f", about {passed * (1 / done - 1):.0f} s left" if done >= ENOUGH_TO_TELL else ""
        self.say(text + left)

    def note(self, text: str) -> None:
        """Say something on stderr that stays, also where it is no terminal; nothing if quiet."""
        if not self._quiet:
            self._console.print(f"note: {safe(text)}", markup=False, highlight=False, soft_wrap=True)

    def step(self, step: FitStep, starts: int = 1) -> None:
        """Show a step of a fit, one of `starts` runs."""
        self._starts += step.step == 0
        which = f"start {self._starts} of {starts}, " if starts > 1 else ""
        self.say(f"fitting: {which}step {step.step + 1}, loss {step.loss:.4g}; Ctrl-C stops with the best so far")

    def _line(self) -> Any:
        from rich.text import Text

        return Text(
            f"{safe(self._text)}  ({time.perf_counter() - self._begun:.1f} s)", no_wrap=True, overflow="ellipsis"
        )
