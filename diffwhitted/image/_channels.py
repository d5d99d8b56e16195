"""Which channels of a file are its picture: by the names of parts, layers and channels."""

from collections.abc import Sequence
from typing import NamedTuple

from ._faults import Unusable

_LETTERS = {"red": "r", "green": "g", "blue": "b", "alpha": "a"}
_DEPTH = {"z", "zback", "depth", "distance"}
"""Words in the name of a part or channel that is no light."""
_MOST_LISTED = 24


class Part(NamedTuple):
    """One of the images in a file: its name ("" for none) and its channels'."""

    name: str
    channels: tuple[str, ...]


class Choice(NamedTuple):
    """The channels of a picture: part and channels of colour (three, or one of grey), and of alpha.

    layer: what stands before the last dot of its channels, "" for nothing.
    """

    part: int
    layer: str
    colour: tuple[int, ...]
    alpha: int | None = None


def choose_channels(parts: Sequence[Part], wanted: str | None) -> Choice:
    """The picture called `wanted` (a layer, a part, both with a dot between, or one channel), or else the one there is.

    A layer is a picture with channels R, G, B, or as one of grey with Y or R alone; so is the only channel of a
    file, whatever its name. Depth never is. Without a word three channels come before one, and what is in no
    layer before layers. Raises Unusable where that leaves none or several.
    """
    pictures = [picture for index, part in enumerate(parts) for picture in _pictures(index, part)]
    if not pictures and len(parts) == 1 and len(parts[0].channels) == 1 and not _is_depth(parts[0], 0):
        pictures = [Choice(0, parts[0].channels[0].rpartition(".")[0], (0,))]
    if wanted is not None:
        found = _by_name(parts, pictures, wanted)
    else:
        found = [picture for picture in pictures if len(picture.colour) == 3] or pictures
    found = _outside(found)
    if len(found) != 1:
        raise Unusable(_refusal(parts, pictures, wanted, several=len(found) > 1))
    return found[0]


def _outside(found: list[Choice]) -> list[Choice]:
    """Of several pictures those outside of layers, if there are any."""
    return found if len(found) == 1 else [picture for picture in found if not picture.layer] or found


def _pictures(index: int, part: Part) -> list[Choice]:
    """The pictures in a part."""
    layers: dict[str, dict[str, int]] = {}
    for channel, name in enumerate(part.channels):
        prefix, _, last = name.rpartition(".")
        layers.setdefault(prefix, {})[_LETTERS.get(last.lower(), last.lower())] = channel
    pictures = []
    for layer, letters in layers.items():
        alpha = letters.get("a")
        if letters.keys() >= {"r", "g", "b"}:
            pictures.append(Choice(index, layer, tuple(letters[letter] for letter in "rgb"), alpha))
        elif grey := _grey(letters):
            if not _is_depth(part, letters[grey]):
                pictures.append(Choice(index, layer, (letters[grey],), alpha))
    return pictures


def _grey(letters: dict[str, int]) -> str | None:
    """The channel of a picture of one: Y without X (a place) and without RY, BY (a coded colour), or R alone."""
    if "y" in letters and not letters.keys() & {"r", "ry", "by", "x"}:
        return "y"
    return "r" if "r" in letters and not letters.keys() & {"g", "b", "y"} else None


def _is_depth(part: Part, channel: int) -> bool:
    """Is a word of the name of the part or of the channel one for depth?"""
    words = f"{part.name}.{part.channels[channel]}".lower().split(".")
    return not _DEPTH.isdisjoint(words)


def _by_name(parts: Sequence[Part], pictures: Sequence[Choice], wanted: str) -> list[Choice]:
    """The pictures that the name may mean; a single channel by its whole name only where there is none."""

    def names(index: int, name: str) -> set[str]:
        part = parts[index].name
        return {name, part, f"{part}.{name}"} if part else {name}

    found = [picture for picture in pictures if wanted in names(picture.part, picture.layer)]
    exact = [picture for picture in found if picture.layer == wanted]
    if found:
        return exact or found
    return [
        Choice(index, name, (channel,))
        for index, part in enumerate(parts)
        for channel, name in enumerate(part.channels)
        if wanted in names(index, name) - {part.name} and not _is_depth(part, channel)
    ]


def _refusal(parts: Sequence[Part], pictures: Sequence[Choice], wanted: str | None, *, several: bool) -> str:
    """What is wrong, which channels there are, and how to ask for a picture."""
    channels = [f"{part.name}: {name}" if len(parts) > 1 else name for part in parts for name in part.channels]
    listed = ", ".join(channels[:_MOST_LISTED]) + (f" and {len(channels) - _MOST_LISTED} more" * (len(channels) > 24))
    names = sorted({_name(parts, pictures, picture) for picture in pictures} - {""})
    if several:
        problem = "has several layers, none asked for" if wanted is None else f"has several layers called {wanted!r}"
    else:
        problem = "has no R, G, B, no Y and no R alone" + (f" under the name {wanted!r}" if wanted is not None else "")
    remedy = f"a picture is chosen by FILE:NAME or layer = NAME, with the name {' or '.join(map(repr, names))}"
    if not names:
        remedy = "one channel that holds light, if there is any, is chosen as grey by FILE:NAME or layer = NAME"
    return f"it {problem}; its channels are {listed}; {remedy}"


def _name(parts: Sequence[Part], pictures: Sequence[Choice], picture: Choice) -> str:
    """The shortest name that means this picture alone."""
    part = parts[picture.part].name
    names = [picture.layer, part, f"{part}.{picture.layer}"]
    alone = (name for name in names if name and _outside(_by_name(parts, pictures, name)) == [picture])
    return next(alone, names[-1].strip("."))
