"""How long a fit and its stages took, in words."""

import math
from collections.abc import Sequence
from dataclasses import replace

from .._result import FitStage


def seconds_text(seconds: float) -> str:
    """A duration: `0.42 s`, `12.3 s`, `3 min 05 s`."""
    if not math.isfinite(seconds):
        return "unknown"
    if seconds < 59.95:
        return f"{seconds:.2f} s" if seconds < 10 else f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s"


def joined(stages: Sequence[FitStage]) -> list[FitStage]:
    """The stages, of which those of one name that follow one another are one."""
    found: list[FitStage] = []
    for stage in stages:
        if found and found[-1].name == stage.name:
            last = found.pop()
            stage = replace(stage, steps=last.steps + stage.steps, seconds=last.seconds + stage.seconds)
        found.append(stage)
    return found


def stage_text(stage: FitStage) -> str:
    """`one pixel in 8: 7 steps in 0.12 s`."""
    return f"{stage.name}: {stage.steps} step{'' if stage.steps == 1 else 's'} in {seconds_text(stage.seconds)}"
