"""Errors that a person can act on: one message each, naming the place, the value and the way out."""

import unicodedata

_UNPRINTABLE = {"Cc", "Cs", "Zl", "Zp"}
"""Categories of Unicode: control characters, halves of pairs (bytes of a file name that are no text), breaks of
lines.
"""
_TURNING = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}
"""Characters that turn the direction in which those after them are shown."""


def _is_plain(character: str) -> bool:
    """Does a terminal show the character, and do nothing else with it?"""
    return unicodedata.category(character) not in _UNPRINTABLE and unicodedata.bidirectional(character) not in _TURNING


def printable(text: str) -> str:
    """The text with what would steer a terminal written out, such as \\x1b; line breaks and tabulators stay.

    Names of files and things may hold anything. Every message goes through here.
    """
    return "".join(
        c if c in "\n\t" or _is_plain(c) else c.encode("unicode_escape", "surrogatepass").decode() for c in text
    )


class InputError(ValueError):
    """Something that was given (a scene, an image, a name) cannot be used as it is."""

    def __init__(self, message: object = ""):
        super().__init__(printable(str(message)))


class SceneError(InputError):
    """A scene, or one of its records, is not valid."""


class FarFromOrigin(UserWarning):
    """A scene lies so far from the origin of its coordinates that what was given in float32 is blurred."""


class CapacityError(RuntimeError):
    """A ray tree outgrew the room that its plan gave it."""


class SceneNote(UserWarning):
    """Something about a scene that a person should know, and that is no error."""
