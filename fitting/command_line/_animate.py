"""`diffwhitted animate`: a film of a scene whose numbers change."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from ._between import Between
from ._environment import set_up
from ._options import CameraName, Depth, Footprint, Height, Samples, ScenePath, Width, chosen_camera
from ._progress import Progress, say

Out = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE",
        show_default=False,
        help="film.mp4 (.mov .webm .mkv; takes ffmpeg), film.gif, or numbered pictures such as frames/%04d.exr.",
    ),
]
Sets = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="NAME=V0:V1",
        show_default=False,
        help="A number of `diffwhitted parameters` along keyframes: glass.k_d=0.1:0.5, or [x,y,z]:[x,y,z] of several; "
        "three values or more are evenly spaced keyframes. NAME=orbit:360 turns a place about the vertical through "
        "what the camera looks at.",
    ),
]
FrameCount = Annotated[int, typer.Option("--frames", metavar="N", min=1, max=100_000, help="Pictures in all.")]
Rate = Annotated[float, typer.Option("--fps", metavar="RATE", min=0.1, max=240, help="Pictures a second.")]
How = Annotated[
    Between,
    typer.Option("--between", metavar="WAY", help="linear, or smooth: at rest at both ends, without a corner between."),
]
Exposure = Annotated[
    float, typer.Option("--exposure", metavar="STOPS", help="For what a display shows: +1 doubles the light.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress.")]


def animate(
    scene: ScenePath,
    out: Out,
    set: Sets,
    frames: FrameCount = 48,
    fps: Rate = 24.0,
    between: How = Between.linear,
    camera: CameraName = None,
    width: Width = None,
    height: Height = None,
    depth: Depth = None,
    samples: Samples = 1,
    footprint: Footprint = None,
    exposure: Exposure = 0.0,
    quiet: Quiet = False,
) -> None:
    """Write a film of a scene whose numbers change.

    \b
    Once around what the camera looks at, in two seconds:
      diffwhitted animate scene.toml --set camera.main.look_from=orbit:360 --frames 48 -o film.mp4

    Frames are traced side by side by one compiled program; a film for eyes takes one filtered tree a pixel (--footprint
    1) unless --samples or --footprint say otherwise. Numbered pictures that are there, of the same film, are kept: a
    film that was interrupted goes on. Motion blur is that of the scene (shutter, velocity).
    """
    set_up()
    from diffwhitted import load_scene
    from diffwhitted.records import changed
    from diffwhitted.rendering._frames import Frames

    from ._film_file import film_at
    from ._keyframes import courses, scene_at, times
    from ._render import chosen_footprint

    loaded = load_scene(scene)
    name, view = chosen_camera(loaded, camera)
    loaded = changed(loaded, cameras={**loaded.cameras, name: view.resized(width, height)})
    found = courses(loaded, name, set, between)
    at = times(found, frames)
    trees = chosen_footprint(footprint, samples, loaded.footprint, for_eyes=out.suffix.lower() not in LINEAR)
    asked = [*set, between.value, frames, name, depth, samples, trees, exposure]
    film = film_at(out, fps, exposure, f"{_contents(loaded)} {asked}", {"scene": scene.name, "camera": name})
    wanted = [number for number in range(frames) if number not in film.there]
    # Refuse what some frame cannot be before the first one is traced.
    for number in {0, frames // 2, frames - 1}:
        scene_at(loaded, found, at[number])
    tracing = Frames(name, tuple(course.name for course in found), depth, samples, trees)
    begun = time.perf_counter()
    try:
        with Progress(f"frame 1 of {len(wanted)}, compiling", quiet=quiet) as progress:
            pictures = tracing.traced(lambda number: scene_at(loaded, found, at[number]), wanted)
            for done, (number, pixels) in enumerate(pictures, 1):
                film.add(number, pixels)
                progress.part(f"frame {done} of {len(wanted)}", done / len(wanted))
            film.end()
    except BaseException:
        film.give_up()
        raise
    seconds, picture = time.perf_counter() - begun, loaded.cameras[name]
    kept = f", {len(film.there) - len(wanted)} of them kept" if len(film.there) > len(wanted) else ""
    programs = f"{len(tracing.plans)} programs" if len(tracing.plans) != 1 else "one program"
    size = f"{picture.width} x {picture.height} pixels"
    say(f"wrote {out}: {frames} frames of {size}{kept}, in {seconds:.1f} s, {programs}")


LINEAR = (".exr", ".hdr", ".tif", ".tiff")


def _contents(scene) -> str:
    """What is in a scene, pictures and meshes too, as a digest."""
    import hashlib

    import jax
    import numpy as np

    leaves, structure = jax.tree.flatten(scene)
    content = hashlib.sha256(str(structure).encode())
    for leaf in leaves:
        content.update(np.ascontiguousarray(leaf).tobytes())
    return content.hexdigest()
