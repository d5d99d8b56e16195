"""The files that a fit leaves in a folder: all of one fit, or recognisably not whole."""

from __future__ import annotations

import errno
import json
import os
import re
import secrets
import shutil
from collections.abc import Callable, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from diffwhitted._errors import printable
from diffwhitted._files import not_a_file

from .._result import FitResult
from ._report import report_html

UNFINISHED = "unfinished"
"""The folder in which files that belong together are made."""


class OutputError(OSError):
    """The results cannot be written: which file or folder, why, and what to try, in one message."""

    def __init__(self, message: str):
        super().__init__(printable(message))


def write_outputs(
    result: FitResult,
    folder: str | os.PathLike,
    *,
    title: str,
    save_scene: Callable[[Any, Path], Any],
    truth: Mapping[str, float] | None = None,
    metadata: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Writes `result.json`, `fitted.toml`, `render.exr`, `residual.exr` and `report.html`.

    Where `result.json` stands, all of them stand and are of one fit, whenever the program is ended (see
    `write_together`).

    With several views the pictures carry the camera's name: `render_left.exr`. Pictures are linear
    Rec. 709; the residual is `render - target`, 0 outside the mask.

    - `folder`: made if it is missing; files of these names in it are replaced.
    - `save_scene`: writes a scene to a path that ends in `.toml`.
    - `title`, `truth`: for the report, as in `report_html`.
    - `metadata`: JSON values that go into the pictures and, as `metadata`, into `result.json`.

    Returns the paths in this order. Raises `OutputError` where something cannot be written; the folder is then as
    it was before, and what was made is in `unfinished`.
    """
    from diffwhitted.image import write_image

    folder = Path(folder)
    about = dict(metadata or {})

    def text(content: Callable[[], str]) -> Callable[[Path], Any]:
        return lambda path: path.write_text(content(), encoding="utf-8")

    def picture(pixels: Any, view: str, kind: str) -> Callable[[Path], Any]:
        described = {**about, "camera": view, "content": kind}
        return lambda path: write_image(path, pixels, metadata=described)

    content = {**result.to_json(), **({"metadata": about} if about else {})}
    jobs: dict[str, Callable[[Path], Any]] = {
        "result.json": text(lambda: json.dumps(content, indent=2, allow_nan=False, default=str) + "\n"),
        "fitted.toml": lambda path: save_scene(result.scene, path),
    }
    for view, suffix in zip(result.views, suffixes([view.camera for view in result.views]), strict=True):
        jobs[f"render{suffix}.exr"] = picture(view.render, view.camera, "render with the fitted coefficients")
        jobs[f"residual{suffix}.exr"] = picture(view.residual, view.camera, "render - target")
    # The page is made last: whatever it meets, the numbers are on the disk by then.
    jobs["report.html"] = text(lambda: report_html(result, title=title, truth=truth))
    return write_together(folder, jobs, last="result.json")


def write_together(folder: Path, jobs: Mapping[str, Callable[[Path], Any]], last: str) -> list[Path]:
    """Writes the files of a folder so that, whenever the program is ended, all are of one run where `last` stands.

    All are made in the folder `unfinished` within it. Then `last` is taken away, the others are renamed to their
    places, and `last` at the end. Where something fails, what was made so far stays in `unfinished`, which the next
    run replaces.

    Returns the paths in the order of `jobs`. Raises `OutputError`.
    """
    from diffwhitted.image import ImageError

    made = folder / UNFINISHED
    # Look first whether everything can be put in its place.
    with explained(folder):
        folder.mkdir(parents=True, exist_ok=True)
    for name in jobs:
        with explained(folder / name):
            _check_replaceable(folder / name)
    # Make the files.
    with explained(made):
        if made.is_dir():
            shutil.rmtree(made)
        made.mkdir()
    for name, write in jobs.items():
        try:
            with explained(folder / name):
                write(made / name)
        except ImageError as error:
            raise OutputError(f"cannot write results: {error}") from error
    # Put them in their places.
    with explained(folder):
        (folder / last).unlink(missing_ok=True)
        for name in sorted(jobs, key=lambda name: name == last):
            os.replace(made / name, folder / name)
        made.rmdir()
    return [folder / name for name in jobs]


def _check_replaceable(path: Path) -> None:
    """Raise an operating system's error where a file of this name cannot be replaced by another."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "there is a folder of this name", str(path))
    if kind := not_a_file(path):
        raise IsADirectoryError(errno.EISDIR, f"there is {kind} of this name", str(path))


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Calls `write` on a hidden name beside `path` and renames; nothing stays where it fails."""
    _check_replaceable(path)
    temporary = path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")
    try:
        write(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def explained(path: Path):
    """Turns an operating system's error into one message on `path`, with what to try."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        reason = (error.strerror or str(error) or type(error).__name__).lower()
        if isinstance(error, (FileExistsError, NotADirectoryError)):
            reason, advice = (
                "a file stands where a folder is needed",
                "choose another folder with --out, or move the file",
            )
        elif isinstance(error, PermissionError):
            advice = "choose a folder of your own with --out"
        elif isinstance(error, IsADirectoryError):
            advice = "choose another folder with --out, or move that one"
        else:
            advice = "check that the disk has room and the path is right, or choose another folder with --out"
        raise OutputError(f"cannot write {path}: {reason}; {advice}") from error


def suffixes(cameras: list[str]) -> list[str]:
    """What follows `render` and `residual` for each camera: nothing for one, otherwise its name, made
    safe for a file and unlike the others."""
    if len(cameras) == 1:
        return [""]
    taken: list[str] = []
    for camera in cameras:
        plain = "_" + (re.sub(r"[^\w.-]+", "_", camera).strip("._") or "camera")
        number, suffix = 2, plain
        # Two names that differ by case alone are one file on some disks.
        while suffix.lower() in (other.lower() for other in taken):
            number, suffix = number + 1, f"{plain}_{number}"
        taken.append(suffix)
    return taken
