"""Pictures as programs of their own, whose compilation and runs are timed."""

import itertools
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jax.experimental.compilation_cache import compilation_cache

from ..numerics._workers import side_by_side

FEWEST_ROUNDS, MOST_ROUNDS = 5, 25
ROUNDS_SECONDS = 4.0
"""Every program is run once a round, for about so long in all."""
CERTAIN = 3.0
"""A share counts from this many of its standard errors on."""
SMALLEST_SHARE = 0.005
_numbers = itertools.count()


@dataclass(frozen=True, eq=False)
class Program:
    """Something compiled, the inputs of its passes, and what compiling took."""

    run_pass: Callable[[Any], Any]
    inputs: list
    seconds_compile: float
    """Processor seconds to trace the Python code and to compile what comes of it."""

    def run(self) -> list:
        """All passes, side by side as `render` runs them."""
        return side_by_side(self.run_pass, self.inputs)


def compiled(work: Callable, inputs: list) -> Program:
    """`work` compiled for inputs of one kind, neither found among programs that were compiled before nor kept for
    later.
    """

    def fresh(given):
        return work(given)

    # A program is known again by its name and its content.
    fresh.__name__ = f"measured_{next(_numbers)}"
    begun = time.process_time()
    with _nothing_kept():
        program = eqx.filter_jit(fresh).lower(inputs[0]).compile()
    return Program(program, inputs, time.process_time() - begun)


@contextmanager
def _nothing_kept():
    """Programs are compiled, not read from the user's cache, and not written to it. JAX looks only once whether there
    is one.
    """
    folder = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    jax.config.update("jax_compilation_cache_dir", None)
    compilation_cache.reset_cache()
    try:
        yield
    finally:
        jax.config.update("jax_compilation_cache_dir", folder)
        compilation_cache.reset_cache()


def timed(programs: dict[str, Program]) -> dict[str, np.ndarray]:
    """Seconds of some runs of each: all take turns, so that a change of the machine's speed meets all of them."""
    seconds = {name: [] for name in programs}
    begun, rounds = time.perf_counter(), 0
    while rounds < FEWEST_ROUNDS or (rounds < MOST_ROUNDS and time.perf_counter() - begun < ROUNDS_SECONDS):
        for name, program in programs.items():
            start = time.perf_counter()
            program.run()
            seconds[name].append(time.perf_counter() - start)
        rounds += 1
    return {name: np.asarray(runs) for name, runs in seconds.items()}


def share_without(whole: np.ndarray, less: np.ndarray) -> tuple[float, bool]:
    """1 - less / whole and whether it is below noise: the median over the rounds, its standard error from their
    median absolute deviation.
    """
    shares = 1 - less / whole
    share = float(np.median(shares))
    # Of normally distributed values: standard deviation 1.48 MAD, standard error of the median 1.25 of the mean's.
    error = 1.25 * 1.48 * float(np.median(np.abs(shares - share))) / len(shares) ** 0.5
    return share, bool(share < max(CERTAIN * error, SMALLEST_SHARE))
