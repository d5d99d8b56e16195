"""Options of a fit that say what is known besides the pictures."""

from typing import Annotated

import typer

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
