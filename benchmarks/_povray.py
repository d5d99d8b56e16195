"""POV-Ray as a reference: its picture, its own count of rays, and the trace time that it prints."""

import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import diffwhitted

MISSING = "povray is not installed (Debian package povray)"
COUNTS = {"all": r"Rays:\s+(\d+)", "mirror": r"Reflected Rays:\s+(\d+)", "transmitted": r"Refracted Rays:\s+(\d+)"}


@dataclass(frozen=True)
class Traced:
    """One run of POV-Ray."""

    seconds: float
    """"Trace Time", with two threads, without start, parsing and the writing of the file."""
    counts: dict[str, int]
    pixels: np.ndarray
    """Linear RGB, half floats."""


def available() -> bool:
    return shutil.which("povray") is not None


def trace(scene: Path, width: int, height: int, antialias: tuple[str, ...] = ("-A",)) -> Traced:
    """Render a scene file, without antialiasing or with these options of POV-Ray."""
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.exr"
        command = ["povray", f"+I{scene}", f"+O{picture}", "+FE", f"+W{width}", f"+H{height}", *antialias, "+WT2", "-D"]
        done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
        found = re.search(r"Trace Time:.*\(([\d.]+) seconds\)", done.stderr)
        if done.returncode or not found:
            raise RuntimeError(f"povray failed: {done.stderr[-500:]}")
        counts = {name: int((re.findall(pattern, done.stderr) or [0])[0]) for name, pattern in COUNTS.items()}
        return Traced(float(found[1]), counts, diffwhitted.read_image(picture).pixels)
