"""`diffwhitted fit`: from target pictures to coefficients, a fitted scene and a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ._environment import set_up
from ._fit_map import fit_map, refuse_beside_texture
from ._folder import check_folder, saved_into
from ._options import Depth, Footprint, HoldOut, Only, Precision, PrecisionName, Samples, ScenePath
from ._progress import Progress, safe
from ._restrictions import AtMost, BoundsGiven, Colours, Known, Loss, LossName, Priors, Start, TiesGiven

if TYPE_CHECKING:
    from fitting import FitResult

Targets = Annotated[
    list[str] | None,
    typer.Option(
        "--target",
        metavar="[CAMERA=]IMAGE",
        show_default=False,
        help="Picture to fit, one for each camera. Integers are read as sRGB, floats as linear Rec. 709, unless the "
        "file says otherwise. Its alpha channel, if any, is its mask. Default: the [[shot]] tables of the scene.",
    ),
]
FREE = typer.Option(
    "--free",
    metavar="NAME",
    show_default=False,
    help="Number to find: MATERIAL.COEFFICIENT, such as glass.k_d, or another name that `diffwhitted parameters` "
    "lists, such as light.key.position or object.ball.centre.x. Wildcards in quotes, so that the shell leaves them "
    'alone: "*.k_d", "glass.*" mean materials, "light.*" lights.',
)
Free = Annotated[list[str], FREE]
FreeOrNone = Annotated[list[str] | None, FREE]
TextureName = Annotated[
    str | None,
    typer.Option(
        "--texture",
        metavar="NAME",
        show_default=False,
        help="In place of --free: find the texels of this image texture, each with a standard error.",
    ),
]
Out = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        metavar="DIR",
        show_default=False,
        help="Folder for report.html, result.json, fitted.toml, render.exr and residual.exr.",
    ),
]
CameraName = Annotated[
    str | None,
    typer.Option(
        "--camera",
        metavar="NAME",
        show_default=False,
        help='Camera of a target that names none. Default: "main", or the only one.',
    ),
]
Masks = Annotated[
    list[str] | None,
    typer.Option(
        "--mask",
        metavar="[CAMERA=]FILE",
        show_default=False,
        help="Grey image of the target's size: 1 (white) where a pixel counts, 0 where it does not. Default: the "
        "target's alpha.",
    ),
]
KeepClipped = Annotated[
    bool,
    typer.Option(
        "--keep-clipped",
        help="Use pixels at the largest code of an 8 or 16 bit target too; they are masked where there are many.",
    ),
]
Noise = Annotated[
    str | None,
    typer.Option(
        "--noise",
        metavar="SIGMA|read=R,gain=G|FILE",
        show_default=False,
        help="Standard deviation of the target's pixels, in linear RGB; or variance = R^2 + G * value; or a picture of "
        "standard deviations. Default: estimated from what the fit leaves over.",
    ),
]
Encoding = Annotated[
    str | None,
    typer.Option(
        "--encoding",
        metavar="NAME",
        show_default=False,
        help="How the numbers of the targets stand for light: linear, srgb, rec709, gamma:2.2. Default: what each file "
        "says, and of one that says nothing, integers sRGB and floats linear.",
    ),
]
Layer = Annotated[
    str | None,
    typer.Option(
        "--layer",
        metavar="NAME",
        show_default=False,
        help="Layer or part of the target files that is the picture; FILE:NAME says it for one file.",
    ),
]
SkipBadPixels = Annotated[
    bool, typer.Option("--skip-bad-pixels", help="Leave out pixels that are NaN or infinite, and say how many.")
]
Starts = Annotated[
    int,
    typer.Option(
        "--starts",
        metavar="N",
        min=1,
        help="Starting points to try: the start, the middle of the bounds, then spread out. The best end counts.",
    ),
]
CoarseToFine = Annotated[
    bool,
    typer.Option(
        "--coarse-to-fine/--all-pixels",
        help="Let the first steps look at fewer pixels of a large target. The last ones look at all of them.",
    ),
]
MaxSteps = Annotated[
    int, typer.Option("--max-steps", metavar="N", min=1, help="Most steps of the solver from one start.")
]
Truth = Annotated[
    Path | None,
    typer.Option(
        "--truth",
        metavar="FILE",
        show_default=False,
        help='True values to set beside the fitted ones: a scene (.toml), or JSON {"glass.k_d": 0.12}.',
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No live progress and no notes.")]
Json = Annotated[bool, typer.Option("--json", help="Print result.json in place of the table.")]


def fit(
    scene: ScenePath,
    out: Out,
    free: FreeOrNone = None,
    texture: TextureName = None,
    target: Targets = None,
    camera: CameraName = None,
    mask: Masks = None,
    only: Only = None,
    hold_out: HoldOut = None,
    keep_clipped: KeepClipped = False,
    encoding: Encoding = None,
    layer: Layer = None,
    skip_bad_pixels: SkipBadPixels = False,
    noise: Noise = None,
    start: Start = None,
    bounds: BoundsGiven = None,
    prior: Priors = None,
    tie: TiesGiven = None,
    at_most: AtMost = None,
    colour: Colours = None,
    loss: LossName = Loss.square,
    starts: Starts = 1,
    samples: Samples = 1,
    footprint: Footprint = None,
    depth: Depth = None,
    max_steps: MaxSteps = 100,
    coarse_to_fine: CoarseToFine = True,
    precision: PrecisionName = Precision.float32,
    truth: Truth = None,
    quiet: Quiet = False,
    json: Json = False,
) -> int:
    """Find the material coefficients, or other numbers of a scene, that make it look like its target pictures.

    \b
    Every k_d, and the gloss of the glass, from one picture:
      diffwhitted fit scene.toml --target photo.exr \\
        --free "*.k_d" glass.k_h glass.phong_exponent \\
        --bounds glass.phong_exponent=5:500 --noise 0.01 --out result

    \b
    A picture on a wall, texel by texel, from two photos (NAME.exr and NAME.standard_errors.exr in the folder):
      diffwhitted fit scene.toml --texture wall --target left=l.exr --target right=r.exr --out result

    A refractive index, a place, a size or a camera moves what is seen: where one is free, each pixel is one filtered
    tree unless --footprint says otherwise. A direction is free by two angles u and v in degrees, counted from the
    scene's; a colour by its channels, where the scene gives three numbers.

    Prints the coefficients with 95 % intervals, and says which ones the pictures do not determine. Ctrl-C
    stops with the best so far, a second Ctrl-C at once. Exit codes: 0 converged, 1 not converged, not
    determined or interrupted, 2 something given cannot be used.
    """
    set_up(precision)
    free = free or []
    if texture is not None:
        refuse_beside_texture(
            free=free, only=only, hold_out=hold_out, start=start, bounds=bounds, prior=prior, tie=tie, at_most=at_most,
            colour=colour, truth=truth, loss=loss != Loss.square, starts=starts > 1, samples=samples > 1,
        )  # fmt: skip
    elif not free:
        raise typer.BadParameter("there is nothing to find; name a number with --free, or a texture with --texture")
    with Progress("reading", quiet=quiet) as progress:
        from diffwhitted import load_scene
        from fitting import fit as run_fit
        from fitting.telling._outputs import write_outputs

        from ._targets import read_targets, with_shots

        loaded = load_scene(scene, precision=precision.value)
        targets = read_targets(
            loaded,
            target or [],
            mask or [],
            camera,
            noise,
            note=progress.note,
            keep_clipped=keep_clipped,
            skip_bad_pixels=skip_bad_pixels,
            encoding=encoding,
            layer=layer,
        )
        if texture is not None:
            options = dict(max_depth=depth, footprint=footprint, max_steps=max_steps)
            return fit_map(loaded, texture, targets, options, out, scene.name, json, progress)
        if only:
            from fitting.problem._only import only_these

            targets = only_these(loaded, targets, only)
        loaded = with_shots(loaded, targets, progress.note)
        known = Known.read(start or [], bounds or [], prior or [], tie or [], at_most or [], colour or [])
        true = known.true_values(loaded, free, truth)
        check_folder(out)
        progress.say("compiling; less to do next time")
        result = run_fit(
            loaded,
            targets,
            free,
            **known.options,
            loss=loss.value,
            starts=starts,
            samples=samples,
            max_depth=depth,
            footprint=footprint,
            max_steps=max_steps,
            coarse_to_fine=coarse_to_fine,
            hold_out=hold_out[0] if hold_out and len(hold_out) == 1 else hold_out or None,
            on_step=lambda step: progress.step(step, starts),
        )
        progress.say("writing the report")
        about = {"scene": scene.name, "targets": [Path(text).name for text in target or []]}
        written = write_outputs(
            result,
            out,
            title=f"{scene.stem}: {', '.join(free)}",
            save_scene=saved_into(out),
            truth=true,
            metadata=about,
        )
    if json:
        print(written[0].read_text(encoding="utf-8"), end="")
    else:
        print_result(result, true, written)
    return result.exit_code


def print_result(result: FitResult, truth: Mapping[str, float] | None, written: Sequence[Path]) -> None:
    """The table, what it means, and where the report is."""
    from rich.console import Console

    from fitting.telling._tables import coefficient_table, summary_lines

    console = Console(highlight=False, soft_wrap=False)
    console.print()
    console.print(coefficient_table(result, truth, console.width))
    console.print()
    for line in summary_lines(result):
        console.print(safe(line), markup=False)
    console.print(safe(f"Report: {written[-1]}"), markup=False, soft_wrap=True)
