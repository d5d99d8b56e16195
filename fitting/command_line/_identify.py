"""`diffwhitted identify`: what a fit would know, before the picture is taken, and where a lamp would tell most."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from ._environment import set_up
from ._fit import BoundsGiven, Free, Quiet
from ._options import Depth, Footprint, Only, Precision, PrecisionName, Samples, ScenePath
from ._progress import Progress, safe

Noise = Annotated[
    list[str] | None,
    typer.Option(
        "--noise",
        metavar="[SHOT=]NOISE",
        show_default=False,
        help="Standard deviation of the pixels' values in linear RGB, such as 0.01, or read=0.005,gain=0.0001 for "
        "variance = read^2 + gain * value; for one shot or camera left=0.02. Default: the noise of the shots.",
    ),
]
Cameras = Annotated[
    list[str] | None,
    typer.Option(
        "--camera",
        metavar="NAME",
        show_default=False,
        help="Camera whose picture is planned; several may be named. Default: the shots of the scene or, without, "
        '"main" or the only camera.',
    ),
]
Suggest = Annotated[
    str | None,
    typer.Option(
        "--suggest",
        metavar="WHAT",
        show_default=False,
        help="Look for the place of one more light or camera (or of light.NAME, camera.NAME) that lowers the standard "
        "errors most.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON in place of the tables.")]


def identify(
    scene: ScenePath,
    free: Free,
    noise: Noise = None,
    camera: Cameras = None,
    only: Only = None,
    bounds: BoundsGiven = None,
    suggest: Suggest = None,
    samples: Samples = 1,
    footprint: Footprint = None,
    depth: Depth = None,
    precision: PrecisionName = Precision.float32,
    quiet: Quiet = False,
    json: Json = False,
) -> int:
    """Say what a fit would know, before any picture is taken: standard errors, and what cannot be told apart.

    \b
    Would one picture with noise of 0.01 tell all k_d and the gloss of the glass?
      diffwhitted identify scene.toml --free "*.k_d" glass.k_h glass.phong_exponent --noise 0.01
    Where would one more lamp tell most?
      diffwhitted identify scene.toml --free "glass.*" --noise 0.01 --suggest light

    The numbers of the scene are taken for true, and each of its shots, or of the cameras named, for a picture. Exit
    codes: 0 everything would be determined (with --suggest: with what is suggested), 1 something would not, 2 something
    given cannot be used.
    """
    set_up(precision)
    with Progress("reading", quiet=quiet) as progress:
        from diffwhitted import load_scene
        from fitting import identify as foretold
        from fitting import suggest as suggested

        from ._named_values import intervals

        loaded = load_scene(scene, precision=precision.value)
        asked = {
            "noise": noises(noise or []),
            "cameras": camera or None,
            "only": only or (),
            "bounds": intervals("--bounds", bounds or []),
            "samples": samples,
            "max_depth": depth,
            "footprint": footprint,
        }
        progress.say("compiling; less to do next time")
        if suggest is None:
            found = foretold(loaded, free, **asked)
            known = found
        else:
            found = suggested(
                loaded, free, suggest, **asked, at_try=lambda number: progress.say(f"looking at place {number}")
            )
            known = found.after
    if json:
        from json import dumps

        print(dumps(found.to_json(), indent=2, allow_nan=False))
    else:
        print_found(found)
    return 0 if known.identifiable else 1


def print_found(found) -> None:
    """The tables with what they mean, and the text to paste."""
    from rich.console import Console

    from fitting.planning._suggest import Suggestion
    from fitting.telling._planned import comparison_table, heading, planned_lines, suggested_lines
    from fitting.telling._tables import coefficient_table

    console = Console(highlight=False)

    def say(lines: Sequence[str]) -> None:
        for line in lines:
            console.print(safe(line), markup=False)

    known = found.before if isinstance(found, Suggestion) else found
    say(["", heading(known), ""])
    console.print(coefficient_table(known, None, console.width))
    say(["", *planned_lines(known)])
    if isinstance(found, Suggestion):
        say(["", *suggested_lines(found), ""])
        console.print(comparison_table(found))
        say(["", "For the scene file:", ""])
        console.print(found.toml, markup=False, soft_wrap=True, end="")


def noises(given: Sequence[str]):
    """From `SIGMA`, `read=R,gain=G` or a picture, and `SHOT=` before any of them: one noise, or by shot; None for none.

    Raises `InputError` for anything else.
    """
    from diffwhitted import InputError

    from ._targets import parsed_noise

    whole, by_name = [], {}
    for text in given:
        name, equals, rest = text.partition("=")
        if equals and name not in ("read", "gain"):
            by_name[name] = parsed_noise(rest)
        else:
            whole.append(parsed_noise(text))
    if len(whole) > 1 or (whole and by_name):
        raise InputError(f"--noise {' '.join(given)}: allowed is one for all, or one for each shot, as in left=0.02")
    return whole[0] if whole else by_name or None
