"""How often 95 % intervals hold the truth: fits of random scenes to the kinds of pictures that people have.

`python -m benchmarks.coverage [COUNT] [KIND ...]`: fits a kind (default 1000), and how the kinds begin (default all).
"""

import sys
import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

import fitting

from ._figures import Figure, show
from ._fresh import run
from ._random_scenes import BRIGHTEST, FREE, KINDS, START, SYSTEMATIC, picture_of, random_scene

COUNT = 1000
LOWEST, HIGHEST = 0.93, 0.97
LOWEST_EACH, HIGHEST_EACH = 0.91, 0.98
WIDEST_CERTAIN, WIDEST_SYSTEMATIC = 6.0, 3.0


@dataclass
class Kind:
    """What the fits of one kind have shown so far, by the names of the free numbers."""

    held: dict[str, list[bool]] = field(default_factory=dict)
    half: dict[str, list[float]] = field(default_factory=dict)
    error: dict[str, list[float]] = field(default_factory=dict)
    certain: int = 0
    without: int = 0
    statuses: Counter = field(default_factory=Counter)
    seconds: float = 0.0

    def add(self, result: fitting.FitResult, truth: dict[str, float], seconds: float) -> None:
        """One more fit; a number without an interval is counted apart."""
        self.seconds += seconds
        self.statuses[result.status] += 1
        self.certain += "certain bounds" in result.message
        for name, value in truth.items():
            found = result[name]
            if found.interval_95 is None:
                self.without += 1
                continue
            low, high = found.interval_95
            self.held.setdefault(name, []).append(bool(low <= value <= high))
            self.half.setdefault(name, []).append((high - low) / 2)
            self.error.setdefault(name, []).append(found.value - value)

    @property
    def fits(self) -> int:
        return sum(self.statuses.values())

    @property
    def each(self) -> dict[str, float]:
        return {name: float(np.mean(held)) for name, held in self.held.items()}

    @property
    def pooled(self) -> float:
        return float(np.mean(sum(self.held.values(), [])))

    @property
    def widths(self) -> dict[str, float]:
        """Median half of an interval over the root of the mean square of the errors."""
        return {
            name: float(np.median(half) / np.sqrt(np.mean(np.square(self.error[name]))))
            for name, half in self.half.items()
        }


def measured(name: str, count: int) -> Kind:
    """So many fits of one kind, the first of which compiles and is not timed."""
    random, found = np.random.default_rng(list(name.encode())), Kind()
    samples = 8 if name.startswith("antialiased") else 1
    while found.fits < count:
        scene, truth = random_scene(random)
        picture = picture_of(scene, samples)
        if picture.max() > BRIGHTEST:
            continue
        target, begun = KINDS[name](picture, random), time.perf_counter()
        result = fitting.fit(scene, target, FREE, start=START)
        found.add(result, truth, time.perf_counter() - begun if found.fits else 0.0)
    return found


def figures(name: str, found: Kind) -> list[Figure]:
    """Of one kind, with what is asked of it."""
    certain, systematic = found.certain > found.fits / 2, name.startswith(SYSTEMATIC)
    each, widths = found.each, found.widths
    least, most = min(each, key=each.__getitem__), max(each, key=each.__getitem__)
    widest = max(widths, key=widths.__getitem__)
    other = ", ".join(f"{count} {status}" for status, count in found.statuses.items() if status != "converged")
    note = (
        f"{found.fits} fits, {found.seconds / max(found.fits - 1, 1):.2g} s each; least {100 * each[least]:.1f} "
        f"({least}), most {100 * each[most]:.1f} ({most}); certain bounds in {found.certain}, "
        f"no interval for {found.without}"
    )
    shown = [Figure(f"{name}: intervals that miss", 100 * (1 - found.pooled), "%", 100 * (1 - LOWEST), note)]
    if not (certain or systematic):
        shown.append(Figure(f"{name}: that hold", 100 * found.pooled, "%", 100 * HIGHEST))
        shown.append(Figure(f"{name}: that hold, at most of one number", 100 * each[most], "%", 100 * HIGHEST_EACH))
        shown.append(
            Figure(f"{name}: that miss, at most of one number", 100 * (1 - each[least]), "%", 100 * (1 - LOWEST_EACH))
        )
    limit = WIDEST_SYSTEMATIC if systematic else WIDEST_CERTAIN
    typical = f"{min(widths.values()):.2f} to {widths[widest]:.2f} ({widest})"
    shown.append(Figure(f"{name}: half an interval / RMS error, at most", widths[widest], "", limit, typical))
    alarms = found.fits - found.statuses["converged"]
    shown.append(Figure(f"{name}: other than converged", alarms, "", 0, other))
    return shown


def measure(count: int = COUNT, begins: tuple[str, ...] = ("",)) -> list[Figure]:
    return [figure for name in KINDS if name.startswith(begins) for figure in figures(name, measured(name, count))]


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if arguments and arguments[0].isdigit():
        count, kinds = int(arguments[0]), tuple(arguments[1:]) or ("",)
        for name in (name for name in KINDS if name.startswith(kinds)):
            show({name: figures(name, measured(name, count))})
    else:
        run("coverage", measure)
