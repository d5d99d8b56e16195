"""Measurements that need a process of their own: cold compiles and peak memory."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from ._scene import FOLDER


def in_fresh_process(module: str, *arguments: object) -> dict:
    """What `python -m benchmarks.MODULE ARGUMENTS` answers, without a persistent compilation cache."""
    environment = os.environ | {"JAX_ENABLE_COMPILATION_CACHE": "false"}
    done = subprocess.run([sys.executable, "-m", f"benchmarks.{module}", *map(str, arguments)], cwd=FOLDER.parent,
                          capture_output=True, text=True, env=environment)
    if done.returncode:
        raise RuntimeError(f"benchmarks.{module} {arguments}: {done.stderr.strip()[-1000:]}")
    return json.loads(done.stdout.splitlines()[-1])


def answer(measure: Callable[..., dict]) -> bool:
    """Where this is such a process, print what `measure` finds for its arguments."""
    if len(sys.argv) < 2:
        return False
    print(json.dumps(measure(*sys.argv[1:])))
    return True


def peak_memory() -> float:
    """Largest resident size of this process so far, in GiB.

    From Linux's VmHWM, which begins anew with each program; `ru_maxrss` is handed down from the process that
    started this one.
    """
    status = Path("/proc/self/status").read_text()
    return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1]) / 2**20
