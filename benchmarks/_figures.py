"""What a benchmark hands back: figures with their targets, and the machine that they hold for."""

import json
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.table import Table

LIBRARIES = ("jax", "jaxlib", "equinox", "optimistix", "numpy")


@dataclass(frozen=True)
class Figure:
    """One measured number. `at_most` is the target, None where there is none; `note` says what stands beside it."""

    name: str
    value: float | None
    """None where it could not be measured; the note says why."""
    unit: str
    at_most: float | None = None
    note: str = ""

    @property
    def verdict(self) -> str:
        if self.value is None:
            return "skipped"
        if self.at_most is None:
            return ""
        return "ok" if self.value <= self.at_most else "short"


def machine() -> dict[str, str]:
    """Processor, cores, memory and versions."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "memory": f"{memory:.0f} GiB",
        "python": platform.python_version(),
        **{name: version(name) for name in LIBRARIES},
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def show(results: Mapping[str, Sequence[Figure]]) -> None:
    """Print the figures of all benchmarks as one table."""
    table = Table("", "figure", "value", "target", "", "beside it", box=SIMPLE, padding=(0, 1))
    for name, figures in results.items():
        for number, f in enumerate(figures):
            colour = {"ok": "green", "short": "red"}.get(f.verdict, "dim")
            value = "-" if f.value is None else f"{f.value:.3g} {f.unit}".strip()
            target = "" if f.at_most is None else f"<= {f.at_most:g}"
            table.add_row("" if number else name, f.name, value, target, f"[{colour}]{f.verdict}[/]", escape(f.note))
        table.add_section()
    console = Console()
    console.width = max(console.width, 150)
    console.print(table)


def save(path: Path, results: Mapping[str, Sequence[Figure]]) -> None:
    """All figures and the machine as JSON, written whole or not at all."""
    content = {
        "machine": machine(),
        "load_average": os.getloadavg()[0],
        "figures": {name: [asdict(f) | {"verdict": f.verdict} for f in figures] for name, figures in results.items()},
    }
    part = path.with_suffix(".part")
    part.write_text(json.dumps(content, indent=1) + "\n")
    part.replace(path)
