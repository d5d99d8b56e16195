"""How XLA calls machine code of numba: its interface for foreign functions, version 0.3.

The compiled function reads and writes XLA's own buffers: no Python is in the way, and passes run on all processors.
"""

import ctypes
from collections.abc import Callable
from typing import Any

import jax
import numba
import numpy as np
from numba import njit, types
from numba.extending import intrinsic

# Names that the declarations of numba leave out.
carray, cfunc = (getattr(numba, name) for name in ("carray", "cfunc"))
EXECUTE = 3
"""The stage of a call in which there is work to do."""


def _pointer_of(typingctx, address):
    del typingctx, address

    def generated(context, builder, signature, arguments):
        del signature
        return builder.inttoptr(arguments[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), generated


_pointer: Any = intrinsic(_pointer_of)


@njit(inline="always")
def _words(address, count):
    return carray(_pointer(address), count, np.int64)


@njit(inline="always")
def _buffer(frame, number, results):
    """Address and size of an argument or a result of the call."""
    described = _words(_words(_words(frame, 16)[14 if results else 9], number + 1)[number], 6)
    rank, size = described[4], 1
    for k in range(rank):
        size *= _words(described[5], rank)[k]
    return described[3], size


@njit(inline="always")
def argument(frame, number, kind):
    """An argument of the call, all its numbers in a row."""
    address, size = _buffer(frame, number, False)
    return carray(_pointer(address), size, kind)


@njit(inline="always")
def result(frame, number, kind):
    """A result of the call, to be written."""
    address, size = _buffer(frame, number, True)
    return carray(_pointer(address), size, kind)


@njit(inline="always")
def _asked_for_version(frame):
    """XLA asks at first which version of its interface this is: tell it."""
    extension = _words(frame, 16)[1]
    if extension == 0:
        return False
    described = _words(extension, 4)
    if (described[1] & 0xFFFFFFFF) != 1:
        return False
    _words(described[3], 5)[3] = 0 | (3 << 32)
    return True


@njit(inline="always")
def to_be_done(frame):
    """Is it a call with work to do? XLA asks at first which version of its interface this is, and is told."""
    return not _asked_for_version(frame) and (_words(frame, 16)[4] & 0xFFFFFFFF) == EXECUTE


_CALL = types.int64(types.int64)
_compiled: dict[str, object] = {}


def registered(kind: str, dtype: str, kernel: Callable) -> str:
    """The name under which XLA calls a kernel, compiled and registered when first asked for.

    `kernel(real)` makes it for a type of number.
    """
    name = f"diffwhitted_{kind}_{dtype}"
    if name not in _compiled:
        _compiled[name] = code = cfunc(_CALL, nopython=True, cache=True)(kernel(np.dtype(dtype).type))
        capsule = ctypes.pythonapi.PyCapsule_New
        capsule.restype, capsule.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        jax.ffi.register_ffi_target(name, capsule(code.address, None, None), platform="cpu", api_version=1)
    return name
