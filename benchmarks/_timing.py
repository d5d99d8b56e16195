"""Clocks: warm up, wait for the result, repeat, and compare programs that take turns."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import jax
import numpy as np


@dataclass(frozen=True)
class Seconds:
    """Times of several runs of one program."""

    runs: tuple[float, ...]

    @property
    def shortest(self) -> float:
        return min(self.runs)

    @property
    def median(self) -> float:
        return float(np.median(self.runs))

    def __str__(self) -> str:
        unit, scale = ("ms", 1e3) if self.median < 1 else ("s", 1)
        return f"{self.shortest * scale:.3g} {unit} min, {self.median * scale:.3g} {unit} median of {len(self.runs)}"


def timed(program: Callable[[], object]) -> float:
    """Seconds until the arrays that `program` returns are there."""
    begun = time.perf_counter()
    jax.block_until_ready(program())
    return time.perf_counter() - begun


def repeated(program: Callable[[], object], runs: int = 15) -> Seconds:
    """Run once to compile and warm up, then time `runs` runs."""
    return taking_turns([program], runs)[0]


def taking_turns(programs: Sequence[Callable[[], object]], runs: int = 15) -> list[Seconds]:
    """Warm up all programs, then time them one after the other, again and again.

    A change of the machine's speed meets all of them, so their ratios hold where single times would not.
    """
    for program in programs:
        timed(program)
    rounds = [[timed(program) for program in programs] for _ in range(runs)]
    return [Seconds(tuple(column)) for column in zip(*rounds, strict=True)]


@dataclass(frozen=True)
class Ratio:
    """How many times as long one program takes as another that took turns with it."""

    of_shortest: float
    median: float
    """The median over the rounds of the ratio within a round."""

    def __str__(self) -> str:
        return f"{self.of_shortest:.3g} of the shortest runs"


def ratio(program: Seconds, reference: Seconds) -> Ratio:
    """The time of `program` over that of `reference`, run by run and for the shortest runs."""
    rounds = np.asarray(program.runs) / np.asarray(reference.runs)
    return Ratio(program.shortest / reference.shortest, float(np.median(rounds)))
