"""Where the pictures of a film go: numbered files, a GIF, or what ffmpeg writes."""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
import shutil
import subprocess
from abc import abstractmethod
from collections.abc import Collection
from pathlib import Path

import numpy as np

from diffwhitted import InputError

VIDEO = (".mp4", ".mov", ".webm", ".mkv")
NUMBER = re.compile(r"%0?\d*d")
SAID = "such as film.mp4 (by ffmpeg), film.gif, or frames/%04d.exr (numbered files of any picture format)"


class Film:
    """A file, or files, that frames are added to in order."""

    there: Collection[int] = ()
    """The numbers of the frames that are there already."""

    @abstractmethod
    def add(self, number: int, pixels: np.ndarray) -> None:
        """Add a frame, linear RGB."""

    @abstractmethod
    def end(self) -> None:
        """All frames are there."""

    def give_up(self) -> None:
        """Leave nothing half-written behind."""


def film_at(out: Path, fps: float, exposure: float, contents: str, metadata: dict) -> Film:
    """The film for a name. Raises `InputError` for a pattern that is none and where ffmpeg is missing.

    `contents`: what decides on the frames, as text; numbered files of the same contents are kept.
    """
    suffix = out.suffix.lower()
    if "%" in str(out):
        return Numbered(out, exposure, contents, metadata)
    if suffix == ".gif":
        return Gif(out, fps, exposure)
    if suffix in VIDEO:
        return Video(out, fps, exposure, ffmpeg(out))
    raise InputError(f"--out {out}: one file of this kind holds no film; allowed is a name {SAID}")


def ffmpeg(out: Path) -> str:
    """The program: that of the package imageio-ffmpeg, or the one on the path. Raises `InputError` where neither is."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe  # pyright: ignore[reportMissingImports]

        return get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        pass
    if found := shutil.which("ffmpeg"):
        return found
    raise InputError(
        f"--out {out}: it takes ffmpeg, which is not here; install it (sudo apt-get install ffmpeg, or pip install "
        "'diffwhitted[film]'), or write film.gif or frames/%04d.png"
    )


class Numbered(Film):
    """A file a frame, each written whole; a list beside them says which belong to this very film."""

    def __init__(self, out: Path, exposure: float, contents: str, metadata: dict):
        from diffwhitted.image import check_writable

        if len(NUMBER.findall(out.name)) != 1 or "%" in NUMBER.sub("", str(out)):
            raise InputError(f"--out {out}: allowed is one number in the name of the file, {SAID}")
        self._out, self._exposure, self._metadata = out, exposure, metadata
        _make_folder(out.parent)
        check_writable(self._place(0), exposure=exposure)
        self._list = out.parent / f".{out.name.replace('%', '')}.film.json"
        self._digest = hashlib.sha256(contents.encode()).hexdigest()
        self.there = self._listed()

    def add(self, number: int, pixels: np.ndarray) -> None:
        from diffwhitted.image import write_image

        write_image(self._place(number), pixels, exposure=self._exposure, metadata={**self._metadata, "frame": number})
        self.there = [*self.there, number]
        self._write_list()

    def end(self) -> None:
        self._write_list()

    def _place(self, number: int) -> Path:
        return self._out.parent / (self._out.name % number)

    def _listed(self) -> list[int]:
        try:
            held = json.loads(self._list.read_text(encoding="utf-8"))
            known = held["frames"] if held["film"] == self._digest else []
            return [int(number) for number in known if self._place(int(number)).is_file()]
        except (OSError, ValueError, TypeError, KeyError):
            return []

    def _write_list(self) -> None:
        held = json.dumps({"film": self._digest, "frames": sorted(self.there)})
        beside = self._list.with_name(f"{self._list.name}.{secrets.token_hex(4)}")
        beside.write_text(held, encoding="utf-8")
        os.replace(beside, self._list)


class Gif(Film):
    """A GIF of 256 colours a frame, by Pillow."""

    def __init__(self, out: Path, fps: float, exposure: float):
        from diffwhitted.image import check_place

        check_place(out)
        self._out, self._fps, self._exposure, self._frames = out, fps, exposure, []

    def add(self, number: int, pixels: np.ndarray) -> None:
        from PIL import Image

        image = Image.fromarray(_codes(pixels, self._exposure))
        self._frames.append(image.quantize(256, dither=Image.Dither.FLOYDSTEINBERG))

    def end(self) -> None:
        beside = self._out.with_name(f".{self._out.name}.{secrets.token_hex(4)}.gif")
        first, *others = self._frames
        first.save(beside, save_all=True, append_images=others, duration=round(1000 / self._fps), loop=0)
        os.replace(beside, self._out)


class Video(Film):
    """What ffmpeg makes of the frames, which it is given one after the other."""

    def __init__(self, out: Path, fps: float, exposure: float, program: str):
        from diffwhitted.image import check_place

        check_place(out)
        self._out, self._fps, self._exposure, self._program = out, fps, exposure, program
        self._beside = out.with_name(f".{out.stem}.{secrets.token_hex(4)}{out.suffix}")
        self._running: subprocess.Popen | None = None

    def add(self, number: int, pixels: np.ndarray) -> None:
        codes = _codes(pixels, self._exposure)
        if self._running is None:
            self._running = self._started(codes.shape[1], codes.shape[0])
        assert self._running.stdin is not None
        try:
            self._running.stdin.write(codes.tobytes())
        except BrokenPipeError:
            self._failed()

    def end(self) -> None:
        assert self._running is not None
        _, said = self._running.communicate()
        if self._running.returncode:
            self._failed(said)
        os.replace(self._beside, self._out)

    def give_up(self) -> None:
        if self._running is not None and self._running.poll() is None:
            self._running.kill()
            self._running.wait()
        self._beside.unlink(missing_ok=True)

    def _started(self, width: int, height: int) -> subprocess.Popen:
        """Of even sides, as most players need them: an odd one gets a black line."""
        raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{self._fps:g}", "-i", "-"]
        even = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]
        words = [self._program, "-y", "-loglevel", "error", *raw, *even, str(self._beside)]
        return subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def _failed(self, said: bytes | None = None) -> None:
        if said is None and self._running is not None:
            said = self._running.communicate()[1]
        line = (said or b"").decode(errors="replace").strip().splitlines()
        raise InputError(f"--out {self._out}: ffmpeg ended with: {line[-1] if line else 'an error'}")


def _codes(pixels: np.ndarray, exposure: float) -> np.ndarray:
    """What a display shows, 8 bits. Raises `InputError` for what is no number."""
    from diffwhitted.image import display_codes

    if not np.isfinite(pixels).all():
        raise InputError("a frame holds NaN or infinity, which no film shows; write frames/%04d.exr to look at it")
    return display_codes(pixels, 8, exposure=exposure)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out {folder}: cannot be made ({(error.strerror or str(error)).lower()})") from None
