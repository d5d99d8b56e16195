"""`diffwhitted render`: a scene file to an image file."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ._environment import set_up
from ._options import CameraName, Depth, Height, Precision, PrecisionName, Samples, ScenePath, Width, chosen_camera

if TYPE_CHECKING:
    import numpy as np

    from diffwhitted import Camera, Plan, Scene

Out = Annotated[Path, typer.Option(
    "--out", "-o", metavar="FILE", show_default=False,
    help="Image to write: .exr .hdr .tif hold linear light, .png .jpg what a display shows.")]
Exposure = Annotated[float, typer.Option(
    "--exposure", metavar="STOPS", help="For .png and .jpg: +1 doubles the light before it is clipped to the display's white.")]


def render(
    scene: ScenePath, out: Out, camera: CameraName = None, width: Width = None, height: Height = None, depth: Depth = None,
    samples: Samples = 1, precision: PrecisionName = Precision.float32, exposure: Exposure = 0.0,
) -> None:
    """Render a scene to an image file.

    \b
    At 640 columns, with nine rays a pixel:
      diffwhitted render scene.toml -o picture.png --width 640 --samples 3
    """
    set_up(precision)
    from diffwhitted import load_scene
    from diffwhitted.image import check_writable, count_clipped, write_image

    form = check_writable(out, exposure=exposure)
    loaded = load_scene(scene, precision=precision.value)
    name, view = chosen_camera(loaded, camera)
    view = view.resized(width, height)
    picture = rendered(loaded, view, depth, samples)
    about = {"scene": scene.name, "camera": name, "samples": samples * samples}
    write_image(out, picture.pixels, exposure=exposure, metadata=about)
    print(f"wrote {out}: {view.width} x {view.height} pixels, {picture.rays:,} rays in {picture.seconds:.2f} s, "
          f"after {picture.seconds_compile:.1f} s of compiling")
    if form.bits and (lost := _clipped_note(count_clipped(picture.pixels, exposure=exposure), view.width * view.height)):
        print(f"note: {lost}", file=sys.stderr)


@dataclass(frozen=True, eq=False)
class Picture:
    """A rendered image, and what it took."""

    pixels: np.ndarray
    rays: int
    seconds: float
    seconds_compile: float


def rendered(scene: Scene, camera: Camera, depth: int | None, samples: int) -> Picture:
    """What `diffwhitted.render` gives, sample by sample, with rays and seconds counted."""
    import jax.numpy as jnp
    import numpy as np

    from diffwhitted._render import record_passes, replay_passes
    from diffwhitted.tree import likely_room, make_plan

    pixels, clock = camera.width * camera.height, Clock()
    plan = make_plan(scene, camera, max_depth=depth, capacity=likely_room(camera))
    total, rays = np.zeros((camera.height, camera.width, 3)), 0
    steps = (np.arange(samples) + 0.5) / samples
    for row, column in np.ndindex(samples, samples):
        offset = jnp.asarray([steps[column], steps[row]], scene.dtype)
        while True:
            trees = clock.run(record_passes, (scene, camera), plan, offset)
            needed = int(np.asarray(trees.descendants).max())
            if needed <= plan.capacity:
                break
            plan = plan.with_capacity(2 * needed)
        total += np.asarray(clock.run(replay_passes, (scene, camera, trees), plan, offset), np.float64)
        rays += pixels + int(np.asarray(trees.descendants).sum())
    mean = (total / samples**2).astype(scene.dtype)
    return Picture(mean, rays, clock.seconds, clock.seconds_compile)


class Clock:
    """Runs programs, and times compiling and running apart."""

    def __init__(self):
        self.seconds = self.seconds_compile = 0.0
        self._compiled = {}

    def run(self, program: Any, inputs: tuple, plan: Plan, offset: Any) -> Any:
        """`program(*inputs, plan, offset)`; compiled once for each plan."""
        import jax

        begun = time.perf_counter()
        if (program, plan) not in self._compiled:
            self._compiled[program, plan] = program.lower(*inputs, plan, offset).compile()
        compiled = time.perf_counter()
        result = jax.block_until_ready(self._compiled[program, plan](*inputs, plan, offset))
        self.seconds_compile += compiled - begun
        self.seconds += time.perf_counter() - compiled
        return result


def _clipped_note(clipped: Any, pixels: int) -> str:
    """A sentence on the pixels that the display cannot show, if any."""
    counts = [f"{clipped.above:,} of {pixels:,} pixels are brighter than the display's white"] if clipped.above else []
    counts += [f"{clipped.below:,} have a negative channel"] if clipped.below else []
    return " and ".join(counts) + "; they are clipped. A lower --exposure, or .exr, keeps them" if counts else ""
