"""`diffwhitted derivative`: the picture of how a picture changes with a coefficient."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ._environment import set_up
from ._options import CameraName, Depth, Height, Precision, PrecisionName, ScenePath, Width, chosen_camera, with_camera
from ._progress import say

if TYPE_CHECKING:
    import numpy as np

    from diffwhitted import Derivative, Scene
    from fitting.problem._unknowns import Unknown

Of = Annotated[
    str,
    typer.Option(
        "--of",
        metavar="NAME",
        show_default=False,
        help="MATERIAL.COEFFICIENT, such as glass.refractive_index, or another name that `diffwhitted parameters` "
        "lists.",
    ),
]
Out = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE",
        show_default=False,
        help="Image to write: .exr .tif hold the derivative itself, linear RGB; .png shows it in signed colours "
        "with a scale.",
    ),
]
Footprint = Annotated[
    int,
    typer.Option(
        "--footprint",
        metavar="K",
        min=0,
        max=64,
        help="K x K filtered trees a pixel; 0: points, whose derivative does not see edges move.",
    ),
]
Refine = Annotated[
    bool,
    typer.Option(
        "--refine/--no-refine",
        help="2 x 2 trees for each of those of the pixels where the derivative is largest, a fifteenth at most.",
    ),
]
Check = Annotated[
    bool,
    typer.Option(
        "--check",
        help="Also measure the central difference of heavily supersampled pictures, and say how well it agrees.",
    ),
]
CheckSamples = Annotated[
    int, typer.Option("--check-samples", metavar="N", min=8, max=256, help="N x N points a pixel for --check.")
]
CheckStep = Annotated[
    float | None,
    typer.Option(
        "--check-step",
        metavar="H",
        show_default=False,
        help="Half the distance of the two pictures. Default: 1e-3 of the value, at least 5e-4.",
    ),
]


def derivative(
    scene: ScenePath,
    of: Of,
    out: Out,
    camera: CameraName = None,
    width: Width = None,
    height: Height = None,
    depth: Depth = None,
    footprint: Footprint = 1,
    refine: Refine = True,
    check: Check = False,
    check_samples: CheckSamples = 64,
    check_step: CheckStep = None,
    precision: PrecisionName = Precision.float32,
) -> None:
    """Write the derivative of a picture in one number of its scene.

    \b
    Where the picture tells of the refractive index, and whether that is true:
      diffwhitted derivative scene.toml --of glass.refractive_index -o slope.png --check
    """
    set_up(precision)
    import numpy as np

    from diffwhitted import load_scene
    from diffwhitted.image import check_writable, write_image

    form = check_writable(out)
    loaded = load_scene(scene, precision=precision.value)
    name, view = chosen_camera(loaded, camera)
    view = view.resized(width, height)
    loaded = with_camera(loaded, name, view)
    unknowns = unknowns_of(loaded, of, depth, name)
    found = derivative_image(loaded, name, unknowns, depth, footprint, refine)
    slope = found.slope
    truth = None
    if check:
        truth, step = difference_image(loaded, name, unknowns, depth, check_samples, check_step)
    if form.bits:
        from ._signed import signed_picture

        signed_picture(out, [slope] if truth is None else [slope, truth], of)
    else:
        write_image(
            out,
            slope,
            metadata={"scene": scene.name, "camera": name, "content": f"d image / d {of}", "footprint": footprint},
        )
    more = f", {np.count_nonzero(found.refined):,} pixels refined" if found.refined.any() else ""
    say(
        f"wrote {out}: {view.width} x {view.height} pixels, largest |d/d {of}| {abs(slope).max():.4g}; "
        f"{found.rays:,} rays{more}"
    )
    if truth is not None:
        print(agreement(slope, truth, check_samples, step))


def unknowns_of(scene: Scene, name: str, depth: int | None, camera: str) -> tuple[Unknown, ...]:
    """What changes: one number, or all channels of a colour at once. Raises `InputError` for several that are no
    colour.
    """
    from diffwhitted import InputError
    from fitting.problem._free_names import free_parameters
    from fitting.problem._unknowns import list_unknowns

    names, _ = free_parameters(scene, [name], depth, {camera})
    unknowns = list_unknowns(scene, names)
    one_colour = len({u.parameter for u in unknowns}) == 1 and all(u.row.coloured for u in unknowns)
    if len(unknowns) > 1 and not one_colour:
        raise InputError(f"--of {name}: these are several numbers; name one of {', '.join(u.name for u in unknowns)}")
    return unknowns


def derivative_image(
    scene: Scene, camera: str, unknowns: tuple[Unknown, ...], depth: int | None, footprint: int, refine: bool
) -> Derivative:
    """Picture and derivative in a number; of a colour along all its channels at once."""
    import jax.numpy as jnp

    from diffwhitted import derivative as in_one_number
    from fitting.problem._unknowns import insert, values_in

    return in_one_number(
        lambda values: insert(scene, unknowns, values),
        jnp.asarray(values_in(scene, unknowns, scene), scene.dtype),
        camera,
        free=tuple(dict.fromkeys(u.parameter.name for u in unknowns)),
        max_depth=depth,
        footprint=footprint,
        refine=refine,
    )


def difference_image(
    scene: Scene, camera: str, unknowns: tuple[Unknown, ...], depth: int | None, samples: int, step: float | None
) -> tuple[Any, float]:
    """The central difference of two supersampled pictures, and half the distance between them."""
    import jax.numpy as jnp
    import numpy as np

    from diffwhitted import render
    from fitting.problem._unknowns import insert, values_in

    values = values_in(scene, unknowns, scene)
    step = step or max(1e-3 * float(abs(values).max()), 5e-4)
    ends = []
    for way in (step, -step):
        moved = insert(scene, unknowns, jnp.asarray(values + way, scene.dtype))
        picture = render(moved, moved.cameras[camera], samples=samples, max_depth=depth, footprint=0)
        ends.append(np.asarray(picture, np.float64))
    return (ends[0] - ends[1]) / (2 * step), step


def agreement(slope: np.ndarray, truth: np.ndarray, samples: int, step: float) -> str:
    """A sentence with cosine and relative L2 distance."""
    import numpy as np

    size = np.linalg.norm(truth)
    if size == 0:
        return f"check: the difference of {samples} x {samples} points a pixel at +-{step:g} is zero everywhere"
    cosine = float((slope * truth).sum() / max(np.linalg.norm(slope) * size, 1e-300))
    away = float(np.linalg.norm(slope - truth) / size)
    return (
        f"check: against the difference of {samples} x {samples} points a pixel at +-{step:g}: cosine {cosine:.4f}, "
        f"relative L2 distance {away:.3f} (noise and step of the difference included)"
    )
