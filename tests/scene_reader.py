"""Reading a text as a file of another program, with all that is said of it."""

import warnings
from collections.abc import Callable
from pathlib import Path

import diffwhitted as dw
from diffwhitted._errors import SceneNote


def reader(path: Path, told: Callable = list) -> Callable:
    """A function of a text, or of bytes: the scene that they are in this file, and the notes on it as `told`."""

    def read(text, **how):
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always", SceneNote)
            made = dw.load_scene(path, **how)
        return made, told(str(note.message) for note in found)

    return read
