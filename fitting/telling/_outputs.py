"""The files that a fit leaves in a folder, each written whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import re
import secrets
from collections.abc import Callable, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .._result import FitResult
from ._report import report_html


class OutputError(OSError):
    """The results cannot be written: which file or folder, why, and what to try, in one message."""


def write_outputs(
    result: FitResult,
    folder: str | os.PathLike,
    *,
    title: str,
    save_scene: Callable[[Any, Path], None],
    truth: Mapping[str, float] | None = None,
    metadata: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Writes `result.json`, `fitted.toml`, `render.exr`, `residual.exr` and `report.html`, in this order.

    With several views the pictures carry the camera's name: `render_left.exr`. Pictures are linear
    Rec. 709; the residual is `render - target`, 0 outside the mask.

    - `folder`: made if it is missing; files of these names in it are replaced.
    - `save_scene`: writes a scene to a path that ends in `.toml`.
    - `title`, `truth`: for the report, as in `report_html`.
    - `metadata`: JSON values that go into the pictures and, as `metadata`, into `result.json`.

    Returns the paths in the order written. Raises `OutputError` where something cannot be written;
    that file is then as it was before, and those written earlier stay.
    """
    from diffwhitted.image import ImageError, write_image

    folder = Path(folder)
    about = dict(metadata or {})
    with explained(folder):
        folder.mkdir(parents=True, exist_ok=True)

    def text(content: Callable[[], str]) -> Callable[[Path], None]:
        return lambda path: write_whole(path, lambda there: there.write_text(content(), encoding="utf-8"))

    def picture(pixels: Any, view: str, kind: str) -> Callable[[Path], None]:
        described = {**about, "camera": view, "content": kind}
        return lambda path: write_image(path, pixels, metadata=described)

    content = {**result.to_json(), **({"metadata": about} if about else {})}
    jobs: list[tuple[str, Callable[[Path], None]]] = [
        ("result.json", text(lambda: json.dumps(content, indent=2, allow_nan=False, default=str) + "\n")),
        ("fitted.toml", lambda path: write_whole(path, lambda there: save_scene(result.scene, there))),
    ]
    for view, suffix in zip(result.views, _suffixes([view.camera for view in result.views]), strict=True):
        jobs += [
            (f"render{suffix}.exr", picture(view.render, view.camera, "render with the fitted coefficients")),
            (f"residual{suffix}.exr", picture(view.residual, view.camera, "render - target")),
        ]
    # The page is made last: whatever it meets, the numbers are on the disk by then.
    jobs.append(("report.html", text(lambda: report_html(result, title=title, truth=truth))))

    written = []
    for name, write in jobs:
        path = folder / name
        try:
            with explained(path):
                write(path)
        except ImageError as error:
            raise OutputError(f"cannot write results: {error}") from error
        written.append(path)
    return written


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Calls `write` on a hidden name beside `path` and renames; nothing stays where it fails."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "there is a folder of this name", str(path))
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


def _suffixes(cameras: list[str]) -> list[str]:
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
