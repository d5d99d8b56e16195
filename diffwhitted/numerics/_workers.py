"""Passes of a picture side by side, one on each processor.

XLA runs one program mostly on one core when its arrays are as small as those of a pass, and a pass needs
nothing from another; so a picture that is rendered outside `jit` hands its passes to as many threads as there
are processors (measured on two: 0.75 of the time, and steady where one thread at a time is not).
"""

import functools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import jax

T = TypeVar("T")
R = TypeVar("R")


def processors() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(program: Callable[[T], R], inputs: Sequence[T]) -> list[R]:
    """`program` of each input, in order, each finished. A jitted program compiles once for all of them."""
    if len(inputs) == 1:
        return [jax.block_until_ready(program(inputs[0]))]
    return list(_threads().map(lambda given: jax.block_until_ready(program(given)), inputs))


@functools.cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(processors(), thread_name_prefix="pass")
