"""Names of cameras from the names of their pictures."""

from collections import Counter
from collections.abc import Sequence
from pathlib import PurePosixPath

from ..._errors import SceneError


def names_of(pictures: Sequence[str], source: str) -> list[str]:
    """A name for each picture: that of its file, with its folders where two share that, without dots.

    Raises `SceneError` where two of them are one and the same.
    """
    paths = [PurePosixPath(picture.replace("\\", "/")) for picture in pictures]
    short = [_plain(path.stem) for path in paths]
    often = Counter(short)
    parts = [[part for part in path.parts[:-1] if part not in (".", "..", "/")] for path in paths]
    names = [
        _plain("_".join([*folders, path.stem])) if often[name] > 1 else name
        for name, path, folders in zip(short, paths, parts, strict=True)
    ]
    for name, count in Counter(names).items():
        if count > 1:
            twice = [picture for picture, other in zip(pictures, names, strict=True) if other == name]
            raise SceneError(
                f"{source}: the pictures {twice[0]!r} and {twice[1]!r} would both be the camera {name!r}; rename one"
            )
    return names


def _plain(name: str) -> str:
    """The name without dots, which part the names of numbers."""
    return name.strip().replace(".", "_") or "picture"
