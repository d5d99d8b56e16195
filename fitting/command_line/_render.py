"""`diffwhitted render`: a scene file to an image file."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ._environment import set_up
from ._on_levels import DisplayName, Levels, chosen_method, write_on_levels
from ._options import (
    Antialias,
    CameraName,
    Cutoff,
    Depth,
    Footprint,
    Height,
    Precision,
    PrecisionName,
    Samples,
    ScenePath,
    TimeBudget,
    Tolerance,
    Width,
    chosen_camera,
)
from ._progress import say

if TYPE_CHECKING:
    import numpy as np

    from diffwhitted import Scene
    from diffwhitted.scene import AbstractCamera

Out = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE",
        show_default=False,
        help="Image to write: .exr .hdr .tif hold linear light, .png .jpg what a display shows.",
    ),
]


class Filter(StrEnum):
    """Reconstruction filters; see `diffwhitted.Shot`."""

    box = "box"
    gaussian = "gaussian"
    mitchell = "mitchell"


Exposure = Annotated[
    float,
    typer.Option(
        "--exposure",
        metavar="STOPS",
        help="For .png and .jpg: +1 doubles the light before it is clipped to the display's white.",
    ),
]
LayersToo = Annotated[
    bool,
    typer.Option(
        "--layers",
        help="For .exr: write what the middle of each pixel sees first beside the picture, as layers: depth.Z (metres "
        "along the ray), normal.X, .Y, .Z, and object.id, whose names the file lists.",
    ),
]
FilterName = Annotated[
    Filter | None,
    typer.Option(
        "--filter",
        metavar="NAME",
        show_default=False,
        help="Reconstruction filter over points (--samples N, default 4): box, the pixel; gaussian, of standard "
        "deviation half a pixel; mitchell. Default: that of --shot, or the plain mean over the pixel.",
    ),
]
ShotName = Annotated[
    str | None,
    typer.Option(
        "--shot",
        metavar="NAME",
        show_default=False,
        help="What this [[shot]] would show: its camera, lamps, filter, exposure and encoding.",
    ),
]


def render(
    scene: ScenePath,
    out: Out,
    camera: CameraName = None,
    width: Width = None,
    height: Height = None,
    depth: Depth = None,
    samples: Samples = 1,
    footprint: Footprint = None,
    cutoff: Cutoff = None,
    antialias: Antialias = None,
    tolerance: Tolerance = None,
    time_budget: TimeBudget = None,
    precision: PrecisionName = Precision.float32,
    exposure: Exposure = 0.0,
    layers: LayersToo = False,
    shot: ShotName = None,
    filter: FilterName = None,
    display: DisplayName = None,
    levels: Levels = 2,
) -> None:
    """Render a scene to an image file.

    \b
    At 640 columns, for eyes:
      diffwhitted render scene.toml -o picture.png --width 640

    A .png or .jpg is antialiased by one filtered tree a pixel (--footprint 1) unless --samples or --footprint say
    otherwise; other formats hold what the scene asks for, by default one point a pixel. With --tolerance or
    --time-budget the settings are found by a search, and remembered in a hidden file beside the scene.
    """
    set_up(precision)
    from diffwhitted import load_scene
    from diffwhitted.image import check_writable, count_clipped, write_image

    form = check_writable(out, exposure=exposure)
    if layers and out.suffix.lower() != ".exr":
        from diffwhitted import InputError

        raise InputError(f"--layers: {out} holds no layers; leave --layers out, or write .exr")
    method = None if display is None else chosen_method(display, levels, out)
    loaded = load_scene(scene, precision=precision.value).with_cutoff(cutoff)
    asked = None
    if shot is not None:
        from ._shown import shot_of

        loaded, asked, of_shot = shot_of(loaded, shot)
        camera = camera or of_shot
    kind = filter.value if filter is not None else asked.filter if asked is not None else None
    name, view = chosen_camera(loaded, camera)
    view = view.resized(width, height)
    found = None
    if kind is not None:
        from ._shown import refuse_beside_filter, under_filter

        refuse_beside_filter(kind, footprint, antialias, tolerance, time_budget)

        picture = under_filter(loaded, view, depth, samples, kind)
        about = {"scene": scene.name, "camera": name, "filter": kind}
    elif tolerance is not None or time_budget is not None:
        from ._accuracy import accuracy_bound, found_picture

        bound = accuracy_bound(
            tolerance,
            time_budget,
            depth=depth,
            samples=samples if samples > 1 else None,
            footprint=footprint,
            cutoff=cutoff,
            antialias=antialias,
        )
        settings, picture, found = found_picture(scene, loaded, view, name, bound)
        about = {"scene": scene.name, "camera": name, "settings": str(settings)}
    elif antialias is None:
        trees = chosen_footprint(footprint, samples, loaded.footprint, for_eyes=bool(form.bits))
        picture = rendered(loaded, view, depth, samples, trees)
        about = {"scene": scene.name, "camera": name, "samples": (trees or samples) ** 2, "footprint": trees}
    else:
        picture = adaptive(loaded, view, depth, samples, footprint, antialias)
        about = {"scene": scene.name, "camera": name, "antialias": antialias}
    channels = None
    if layers:
        from diffwhitted import layers as first_seen

        seen = first_seen(loaded, view)
        channels, about = seen.channels(), {**about, "objects": list(seen.names), "depth.Z": "metres along the ray"}
    pixels = picture.pixels
    if asked is not None:
        from ._shown import as_shown

        pixels, about = as_shown(pixels, asked, bool(form.bits)), {**about, "shot": asked.name}
    if method is None:
        write_image(out, pixels, exposure=exposure, metadata=about, layers=channels)
    else:
        write_on_levels(out, pixels, method, levels, exposure, {**about, "display": display, "levels": levels})
    say(
        f"wrote {out}: {view.width} x {view.height} pixels, {picture.rays:,} rays in {picture.seconds:.2f} s, "
        f"after {picture.seconds_compile:.1f} s of compiling"
    )
    if found is not None:
        print(found)
    if picture.left_out is not None:
        print(
            f"the cutoff of {float(loaded.cutoff):g} and the depth leave out at most {picture.left_out:.2g} in "
            "any pixel"
        )
    if form.bits and (lost := _clipped_note(count_clipped(pixels, exposure=exposure), view.width * view.height)):
        print(f"note: {lost}", file=sys.stderr)


@dataclass(frozen=True, eq=False)
class Picture:
    """A rendered image, and what it took."""

    pixels: np.ndarray
    rays: int
    seconds: float
    seconds_compile: float
    left_out: float | None
    """No pixel lacks more light than this; None where the scene has no cutoff."""


def chosen_footprint(asked: int | None, samples: int, of_scene: int, *, for_eyes: bool) -> int:
    """The footprint to render with. Raises `InputError` where samples and footprint are both asked for."""
    from diffwhitted import InputError

    if asked and samples > 1:
        raise InputError(
            f"--samples {samples} with --footprint {asked}: allowed is one of the two; --footprint {samples} traces "
            f"{samples} x {samples} filtered trees a pixel, --samples {samples} as many points"
        )
    if asked is not None or samples > 1:
        return asked or 0
    return of_scene or int(for_eyes)


def rendered(scene: Scene, camera: AbstractCamera, depth: int | None, samples: int, footprint: int) -> Picture:
    """What `diffwhitted.render` gives, with rays and seconds counted."""
    import jax
    import numpy as np

    from diffwhitted.rendering._passes import lowered_pass, traced_passes
    from diffwhitted.rendering._radiance_bound import most_beyond
    from diffwhitted.scene import near
    from diffwhitted.tree import likely_room, make_plan

    scene, camera = near(scene, camera)
    plan = make_plan(scene, camera, max_depth=depth, capacity=likely_room(camera), footprint=footprint)
    beyond, compiling = most_beyond(scene, camera, plan) if plan.effects.cutoff else None, 0.0
    while True:
        begun = time.perf_counter()
        lowered_pass(scene, camera, plan, samples, beyond).compile()
        compiling += time.perf_counter() - begun
        begun = time.perf_counter()
        pixels, descendants = jax.block_until_ready(traced_passes(scene, camera, plan, samples, beyond))
        seconds, needed = time.perf_counter() - begun, int(descendants.max())
        if needed <= plan.capacity:
            rays = camera.width * camera.height * (footprint or samples) ** 2 + int(
                np.asarray(descendants, np.int64).sum()
            )
            pixels = np.asarray(pixels)
            return Picture(
                pixels[..., :3], rays, seconds, compiling, None if beyond is None else float(pixels[..., 3:].max())
            )
        plan = plan.with_capacity(2 * needed)


def adaptive(
    scene: Scene, camera: AbstractCamera, depth: int | None, samples: int, footprint: int | None, threshold: float
) -> Picture:
    """What `diffwhitted.antialias` gives, with seconds counted."""
    from diffwhitted import InputError
    from diffwhitted import antialias as divided
    from diffwhitted.rendering._antialias import check_threshold, compile_antialias

    if samples > 1 or footprint:
        raise InputError(
            f"--antialias {threshold:g} with --{'samples' if samples > 1 else 'footprint'}: allowed is one way to "
            "antialias"
        )
    check_threshold(threshold)
    begun = time.perf_counter()
    compile_antialias(scene, camera, max_depth=depth)
    compiled = time.perf_counter()
    found = divided(scene, camera, threshold, max_depth=depth)
    return Picture(found.image, found.rays, time.perf_counter() - compiled, compiled - begun, None)


def _clipped_note(clipped: Any, pixels: int) -> str:
    """A sentence on the pixels that the display cannot show, if any."""
    counts = [f"{clipped.above:,} of {pixels:,} pixels are brighter than the display's white"] if clipped.above else []
    counts += [f"{clipped.below:,} have a negative channel"] if clipped.below else []
    return " and ".join(counts) + "; they are clipped. A lower --exposure, or .exr, keeps them" if counts else ""
