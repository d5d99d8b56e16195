"""From an exception to one message and an exit code."""

import errno
import os
import sys
import traceback

from ._progress import say

TRACEBACK = "DIFFWHITTED_TRACEBACK"
"""Set this variable of the environment to see where an error comes from."""


def failed(error: Exception) -> int:
    """Print what went wrong on stderr and return the exit code: 2 for what was given, 1 for the rest."""
    if os.environ.get(TRACEBACK):
        traceback.print_exception(error)
    message, code = _message(error)
    say(f"error: {message}", file=sys.stderr)
    return code


def _message(error: Exception) -> tuple[str, int]:
    from diffwhitted import CapacityError, InputError

    text = " ".join(str(error).split())
    if isinstance(error, InputError):
        return str(error), 2
    if isinstance(error, CapacityError):
        return str(error), 1
    if isinstance(error, MemoryError) or "RESOURCE_EXHAUSTED" in text or "Out of memory" in text:
        return "there is not enough memory for this; try a smaller --width, fewer --samples or a lower --depth", 2
    if isinstance(error, OSError):
        return _os_message(error), 2
    return (
        f"unexpected {type(error).__name__} {text[:300]!r}; {TRACEBACK}=1 in the environment shows where it comes from",
        1,
    )


def _os_message(error: OSError) -> str:
    """The operating system's words, with the file; what this project raises has its own."""
    if error.errno is None:
        return str(error)
    reason = os.strerror(error.errno).lower()
    advice = "make room first" if error.errno == errno.ENOSPC else "check the name and the permissions"
    return f"{error.filename}: {reason}; {advice}" if error.filename else f"{reason}; {advice}"
