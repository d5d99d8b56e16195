"""All benchmarks, each in a fresh process: one table, and `results.json` beside this file.

`python -m benchmarks [NAME ...]` runs all of them or those that are named. Exit code 1 where a target is missed.
"""

import os
import sys

from ._figures import Figure, machine, save, show
from ._fresh import figures_of
from ._scene import FOLDER

BENCHMARKS = (
    "forward", "derivatives", "compile", "edges", "accuracy", "textures", "fit", "coverage", "memory", "waiting",
    "search", "spd", "display", "environment", "materials",
)  # fmt: skip


def main(names: list[str]) -> int:
    unknown = sorted(set(names) - set(BENCHMARKS))
    if unknown:
        print(f"no benchmark {', '.join(unknown)}; there is {', '.join(BENCHMARKS)}", file=sys.stderr)
        return 2
    print(", ".join(f"{key} {value}" for key, value in machine().items()) + f"; load average {os.getloadavg()[0]:.1f}")
    results: dict[str, list[Figure]] = {}
    for name in names or BENCHMARKS:
        print(f"{name} ...", flush=True)
        results[name] = figures_of(name)
    show(results)
    if not names:
        save(FOLDER / "results.json", results)
    return int(any(f.verdict == "short" for figures in results.values() for f in figures))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
