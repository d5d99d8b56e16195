"""Mitsuba 3 as a reference, asked in a process of its own, since it is not among this project's dependencies.

The interpreter is the one in `MITSUBA_PYTHON`, or this one.
"""

import json
import os
import subprocess
import sys

from ._scene import FOLDER

MISSING = (
    "Mitsuba 3 is not there: pip install mitsuba (and libllvm19) somewhere and set MITSUBA_PYTHON to that interpreter"
)


def ask(what: str) -> dict | str:
    """What `python -m benchmarks._mitsuba_scene WHAT` answers, or why there is no answer."""
    python = os.environ.get("MITSUBA_PYTHON", sys.executable)
    try:
        done = subprocess.run(
            [python, "-m", "benchmarks._mitsuba_scene", what],
            cwd=FOLDER.parent,
            capture_output=True,
            text=True,
            timeout=600,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"Mitsuba 3: {error}"
    if "No module named 'mitsuba'" in done.stderr:
        return MISSING
    if done.returncode:
        return f"Mitsuba 3: {done.stderr.strip().splitlines()[-1:]}"
    return json.loads(done.stdout.splitlines()[-1])
