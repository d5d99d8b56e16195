"""A picture with a bound on what its cutoff and its depth limit leave out."""

from dataclasses import dataclass, replace

import numpy as np

from ..scene import AbstractCamera, Scene, depth_number, near, whole_number
from ..tree import likely_room, make_plan
from ._passes import traced_with_room
from ._radiance_bound import most_beyond


@dataclass(frozen=True, eq=False)
class Bounded:
    """A picture, and how much more light the whole tree could bring."""

    image: np.ndarray
    """(height, width, 3), linear Rec. 709 RGB."""
    left_out: np.ndarray
    """(height, width, 3): no tree of up to 64 levels is brighter by more; 0 where nothing was left out, infinite where
    no finite amount can be shown."""
    rays: int

    @property
    def most(self) -> float:
        """The largest bound in the picture."""
        return float(self.left_out.max())


def render_with_bound(
    scene: Scene,
    camera: AbstractCamera,
    *,
    samples: int = 1,
    max_depth: int | None = None,
    footprint: int | None = None,
    cutoff: float | None = None,
) -> Bounded:
    """What `render` gives, with a certified bound on what its `cutoff` and `max_depth` leave out.

    The bound of a pixel is the sum of the throughputs of the branches that were not followed, each times the most light
    that can come along its ray (see `_radiance_bound`). Everything is >= 0, so the picture itself is the lower bound.
    Not under `jit`. Raises `SceneError` for options that are none, `CapacityError` where the tree outgrows the
    memory.
    """
    scene = scene.with_cutoff(cutoff)
    scene, camera = near(scene, camera)
    samples, depth = whole_number(samples, "samples"), depth_number(max_depth) or scene.max_depth
    # A plan of depth 1 knows no branches, and so not what they would have carried.
    plan = make_plan(scene, camera, max_depth=max(depth, 2), capacity=likely_room(camera), footprint=footprint)
    plan, beyond = replace(plan, max_depth=depth), most_beyond(scene, camera, plan)
    image, descendants = traced_with_room(scene, camera, plan, samples, beyond)
    image, rays = np.asarray(image), int(np.asarray(descendants, np.int64).sum())
    left_out = np.zeros_like(image) if image.shape[-1] == 3 else image[..., 3:]
    return Bounded(image[..., :3], left_out, rays + camera.width * camera.height * max(plan.side, samples) ** 2)
