"""Checks of values when a record is built. Traced values pass: they have no value yet."""

import difflib
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from .._errors import InputError, SceneError

DEEPEST = 64
"""The largest max_depth."""


def is_traced(value) -> bool:
    """Is this an abstract value inside `jit`, `grad`, `jvp` or `vmap`?"""
    return isinstance(value, Tracer)


def number_array(value, place: str, field: str, shapes: tuple[tuple[int, ...], ...]) -> Any:
    """`value` as a floating-point array of one of the allowed shapes, finite where it is concrete.

    What is concrete becomes an array of NumPy's: a scene of thousands of records is made in no time, and keeps the
    digits of its numbers until the scene decides on a precision.
    """
    try:
        array = value if is_traced(value) else np.asarray(value, dtype=_float_dtype(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise SceneError(f"{place}: {field} = {value!r} is not a number or a list of numbers") from error
    if array.shape not in shapes:
        allowed = " or ".join(
            "a number" if not s else f"{s[0]} numbers" if len(s) == 1 else f"shape {s}" for s in shapes
        )
        raise SceneError(f"{place}: {field} has shape {array.shape}; allowed is {allowed}")
    if not is_traced(array) and not np.isfinite(array).all():
        raise SceneError(f"{place}: {field} = {listed(array)} is not finite")
    return array


def require(holds, place: str, field: str, value, allowed: str, advice: str = ""):
    """Raise `SceneError` unless `holds()`; not asked where the value is traced."""
    if is_traced(value) or holds(np.asarray(value)):
        return
    raise SceneError(f"{place}: {field} = {listed(value)}; allowed is {allowed}" + (f". {advice}" if advice else ""))


def whole_number(
    value, place: str, lowest: int = 1, highest: int | None = None, error: type[InputError] = SceneError
) -> int:
    """`value` as an int; raises `error` unless it is a whole number, of Python or NumPy, from `lowest` to `highest`."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or value < lowest or (highest is not None and value > highest):
        shown = value.item() if isinstance(value, np.generic) else value
        allowed = f"{lowest} or more" if highest is None else f"from {lowest} to {highest}"
        raise error(f"{place} = {shown!r}; allowed is a whole number {'of ' if highest is None else ''}{allowed}")
    return int(value)


def check_file(file: Path, suffixes: Collection[str], called: str) -> None:
    """Raise `SceneError`, which begins with what it is `called`, unless it is there and ends with one of these."""
    if not file.is_file():
        raise SceneError(f"{called}: there is no such file; paths are relative to the scene file")
    if file.suffix.lower() not in suffixes:
        raise SceneError(f"{called} ends with {file.suffix!r}; allowed is {', '.join(suffixes)}")


def depth_number(max_depth) -> int | None:
    """A checked max_depth; None stays None."""
    return None if max_depth is None else whole_number(max_depth, "max_depth", highest=DEEPEST)


def listed(value) -> str:
    """A short reading of an array for a message."""

    def written(number):
        return repr(shortest(number)).removesuffix(".0")

    value = np.asarray(value)
    if not value.ndim:
        return written(value[()]) if value.dtype.kind == "f" else str(value)
    return np.array2string(value, separator=", ", threshold=12, formatter={"float_kind": written})


def shortest(number) -> float:
    """The number with the fewest digits that reads back as this one in its own precision, whatever NumPy's print
    options.
    """
    return float(np.format_float_scientific(number, unique=True))


def _float_dtype(value):
    dtype = getattr(value, "dtype", None)
    return dtype if dtype is not None and jnp.issubdtype(dtype, jnp.floating) else float


def nearest_name(name: str, known: Iterable[str]) -> str:
    """A sentence ' Did you mean ...?' or nothing."""
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f" Did you mean {close[0]!r}?" if close else ""
