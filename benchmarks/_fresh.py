"""Fresh processes: for cold compiles, for peak memory, and so that no benchmark disturbs the next."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from ._figures import Figure, show
from ._scene import FOLDER

JSON = "--json"


def run(name: str, measure: Callable[[], list[Figure]], part: Callable[..., dict] | None = None) -> None:
    """What `python -m benchmarks.NAME` does: measure and print a table.

    With `--json` it prints the figures as JSON; with other arguments it is the process of a `part`, and prints
    what that finds.
    """
    arguments = sys.argv[1:]
    if arguments == [JSON]:
        print(json.dumps([asdict(figure) for figure in measure()]))
    elif arguments and part is not None:
        print(json.dumps(part(*arguments)))
    else:
        show({name: measure()})


def in_fresh_process(module: str, *arguments: object):
    """What `python -m benchmarks.MODULE ARGUMENTS` answers, without a persistent compilation cache."""
    environment = os.environ | {"JAX_ENABLE_COMPILATION_CACHE": "false"}
    done = subprocess.run(
        [sys.executable, "-m", f"benchmarks.{module}", *map(str, arguments)],
        cwd=FOLDER.parent,
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
    )
    if done.returncode:
        raise SystemExit(f"benchmarks.{module} {' '.join(map(str, arguments))} ended with {done.returncode}")
    return json.loads(done.stdout.splitlines()[-1])


def figures_of(name: str) -> list[Figure]:
    """The figures of one benchmark."""
    return [Figure(**figure) for figure in in_fresh_process(name, JSON)]


def peak_memory() -> float:
    """Largest resident size of this process so far, in GiB.

    From Linux's VmHWM, which begins anew with each program; `ru_maxrss` is handed down from the process that
    started this one.
    """
    status = Path("/proc/self/status").read_text()
    return int(re.findall(r"VmHWM:\s+(\d+) kB", status)[0]) / 2**20
