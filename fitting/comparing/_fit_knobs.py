"""What trades accuracy for time in a fit: one table, and a choice of its values.

A further argument of `fit` that does so is one more row.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from diffwhitted import KNOBS
from diffwhitted.scene import Scene

from ..problem._views import PART_PIXELS


@dataclass(frozen=True)
class FitKnob:
    """A row of the table. Of the group "pixel" (where a pixel is sampled) one knob at most is on."""

    name: str
    costs: str
    controls: str
    off: Any
    """The value at which it does nothing."""
    sweep: tuple
    group: str
    text: str
    """How a setting reads: "depth {}"."""
    argument: str | None
    """Of `fitting.fit`; None for what belongs to the scene."""
    default: Callable[[Scene, bool], Any] = field(repr=False)
    """What `fit` uses for a scene unless it is told otherwise, and whether a free coefficient moves rays decides."""
    least_pixels: int = 0
    """It has an effect on targets of so many, or more."""


def _of_pictures(name: str, sweep: tuple, default: Callable[[Scene, bool], Any], argument: str | None) -> FitKnob:
    """The row of a knob that a picture has too."""
    knob = next(knob for knob in KNOBS if knob.name == name)
    return FitKnob(name, knob.costs, knob.controls, knob.off, sweep, knob.group, knob.text, argument, default)


FIT_KNOBS: tuple[FitKnob, ...] = (
    _of_pictures("depth", (1, 2, 3, 4, 5, 8, 12), lambda scene, moving: scene.max_depth, "max_depth"),
    _of_pictures("cutoff", (0.0, 1 / 256, 1 / 64, 1 / 16), lambda scene, moving: float(scene.cutoff), None),
    _of_pictures("samples", (1, 2, 3), lambda scene, moving: 1, "samples"),
    _of_pictures("footprint", (0, 1, 2), lambda scene, moving: scene.footprint or int(moving), "footprint"),
    FitKnob(
        "coarse_to_fine",
        costs="without it, time: every step looks at all pixels of a large target",
        controls="nothing in the end, as the last steps look at all pixels",
        off=True,
        sweep=(True, False),
        group="steps",
        text="all pixels from the start",
        argument="coarse_to_fine",
        default=lambda scene, moving: True,
        least_pixels=2 * PART_PIXELS,
    ),
)
"""Every knob that trades accuracy for time in a fit."""

COMBINATIONS: tuple[dict[str, Any], ...] = (
    {"depth": 3, "footprint": 1},
    {"depth": 8, "footprint": 1},
    {"depth": 12, "footprint": 1},
    {"depth": 8, "footprint": 2},
    {"depth": 12, "footprint": 2},
)
"""What is measured beside the sweeps: a smaller depth with a footprint, and more of all."""


@dataclass(frozen=True)
class FitSettings:
    """A value for each knob of a table."""

    knobs: tuple[FitKnob, ...] = field(repr=False)
    values: tuple

    @classmethod
    def of(cls, scene: Scene, moving: bool, knobs: Sequence[FitKnob] = FIT_KNOBS) -> "FitSettings":
        """What `fit` uses for this scene; `moving`: a free coefficient moves rays."""
        return cls(tuple(knobs), tuple(knob.default(scene, moving) for knob in knobs))

    def __getitem__(self, name: str) -> Any:
        return self.named()[name]

    def __str__(self) -> str:
        """Such as "depth 4, footprint 1"."""
        on = [knob.text.format(value) for knob, value in self._pairs() if knob.name == "depth" or value != knob.off]
        plain = all(value == knob.off for knob, value in self._pairs() if knob.group == "pixel")
        return ", ".join([*on, "1 point"] if plain else on)

    def named(self) -> dict[str, Any]:
        """The values by the names of their knobs."""
        return {knob.name: value for knob, value in self._pairs()}

    def arguments(self) -> dict[str, Any]:
        """Those of `fitting.fit`."""
        return {knob.argument: value for knob, value in self._pairs() if knob.argument}

    def only(self, **values: Any) -> "FitSettings":
        """These values, and the other ways to sample a pixel off where one of them is such a way."""
        sampled = any(knob.group == "pixel" and knob.name in values for knob in self.knobs)
        rest = {knob.name: knob.off if sampled and knob.group == "pixel" else value for knob, value in self._pairs()}
        return FitSettings(self.knobs, tuple((rest | values)[knob.name] for knob in self.knobs))

    def _pairs(self):
        return zip(self.knobs, self.values, strict=True)
