"""Options of a fit that say what is known besides the pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from diffwhitted import Scene


class Loss(StrEnum):
    """How much large residuals count."""

    square = "square"
    huber = "huber"
    cauchy = "cauchy"
    tukey = "tukey"


Start = Annotated[
    list[str] | None,
    typer.Option(
        "--start",
        metavar="NAME=VALUE",
        show_default=False,
        help="Where the fit begins; wildcards allowed, and NAME=R,G,B for a colour. Default: the values of the scene.",
    ),
]
BoundsGiven = Annotated[
    list[str] | None,
    typer.Option(
        "--bounds",
        metavar="NAME=LOW:HIGH",
        show_default=False,
        help="Interval to search; wildcards allowed. Default: what `diffwhitted parameters` lists, such as 0:1 for "
        "k_*, 1:1e6 for phong_exponent, 1.001:4 for refractive_index.",
    ),
]
Priors = Annotated[
    list[str] | None,
    typer.Option(
        "--prior",
        metavar="NAME=MEAN+-SD",
        show_default=False,
        help="What was known of a number before, such as glass.refractive_index=1.5+-0.02: it counts beside the "
        "pictures, in the values and in their errors. Wildcards allowed.",
    ),
]
TiesGiven = Annotated[
    list[str] | None,
    typer.Option(
        "--tie",
        metavar="NAME=OTHER",
        show_default=False,
        help="The first number follows the second, which is free: mirror.k_h=mirror.k_s, or a=0.5*b.",
    ),
]
AtMost = Annotated[
    list[str] | None,
    typer.Option(
        "--at-most",
        metavar="NAME+NAME=LIMIT",
        show_default=False,
        help="The most that a sum may come to, such as mirror.k_s+mirror.k_t=1; of colours in each channel.",
    ),
]
Colours = Annotated[
    list[str] | None,
    typer.Option(
        "--colour",
        metavar="NAME",
        show_default=False,
        help="Look for three channels where the scene has one number, such as red.k_d. A free channel asks for it too.",
    ),
]
LossName = Annotated[
    Loss,
    typer.Option(
        "--loss",
        metavar="NAME",
        help="square, or, where some pixels are not as the model has them, huber, cauchy or tukey: large residuals "
        "count for less, those of tukey beyond a size for nothing.",
    ),
]


@dataclass(frozen=True)
class Known:
    """What is known besides the pictures, by name."""

    options: Mapping[str, Any]
    """As `fitting.fit` takes it."""

    @staticmethod
    def read(start: Sequence[str], bounds: Sequence[str], prior, tie, at_most, colour) -> Known:
        """From the texts of the options, checked before any work is done. Raises `InputError`."""
        from ._named_values import intervals, numbers, priors, starts, ties

        return Known(
            {
                "start": starts("--start", start),
                "bounds": intervals("--bounds", bounds),
                "prior": priors("--prior", prior),
                "ties": ties("--tie", tie),
                "at_most": numbers("--at-most", at_most, "NAME+NAME=LIMIT, such as mirror.k_s+mirror.k_t=1"),
                "colour": colour,
            }
        )

    def true_values(self, scene: Scene, free: Sequence[str], truth: Path | None) -> dict[str, float] | None:
        """True values by name, from a file."""
        if truth is None:
            return None
        from fitting.problem._colour import coloured
        from fitting.problem._free_names import free_parameters
        from fitting.problem._unknowns import list_unknowns

        from ._named_values import true_values

        scene = coloured(scene, self.options["colour"], free)
        names, _ = free_parameters(scene, (*free, *self.options["ties"]))
        return true_values(truth, scene, list_unknowns(scene, names, self.options["bounds"]))
