"""The pictures of a film: one program for all of them, frames side by side."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import jax
import jax.numpy as jnp
import numpy as np

from ..numerics._workers import processors, side_by_side
from ..scene import Scene, near
from ..tree import Plan, likely_room, make_plan, tables_of
from ._passes import assembled, trace_pass

SPARE = 1.25
"""Room for rays, against what the fullest frame so far has needed, where that was too much."""


@dataclass(eq=False)
class Frames:
    """Scenes that differ in some numbers, seen by one camera.

    The plan is that of the first scene with the effects that these numbers may call for, and so holds for all; where a
    frame calls for more nevertheless, or its rays need more room, there is another one.
    """

    camera: str
    """By name."""
    changing: tuple[str, ...]
    """The names of the numbers."""
    depth: int | None = None
    samples: int = 1
    footprint: int | None = None
    plans: list[Plan] = field(default_factory=list)
    """Those that were needed so far, each a program."""

    def traced(self, scene_of: Callable[[int], Scene], numbers: Sequence[int]) -> Iterator[tuple[int, np.ndarray]]:
        """Each number with the picture of its scene, (height, width, 3), in order.

        As many at a time as there are processors; the first one alone, as it compiles the program. Raises
        `CapacityError` where the tree outgrows the memory.
        """
        waiting = list(numbers)
        while waiting:
            some = waiting[: processors() if self.plans else 1]
            scenes = [scene_of(number) for number in some]
            plan = self._holding(scenes)
            found = side_by_side(lambda scene, plan=plan: self._picture(scene, plan), scenes)
            needed = max(int(most) for _, most in found)
            if needed > plan.capacity:
                self.plans.append(plan.with_capacity(int(SPARE * needed)))
                continue
            yield from ((number, np.asarray(image)) for number, (image, _) in zip(some, found, strict=True))
            waiting = waiting[len(some) :]

    def _holding(self, scenes: Sequence[Scene]) -> Plan:
        """The last plan, or another one where some of the scenes call for more."""
        for scene in scenes:
            asked = self._made(scene)
            if not self.plans:
                self.plans.append(asked)
            elif self.plans[-1].shortfall(asked):
                last = self.plans[-1]
                effects = asked.effects.switched(**dict.fromkeys(last.effects.on, True))
                self.plans.append(replace(asked, effects=effects).with_capacity(last.capacity))
        return self.plans[-1]

    def _made(self, scene: Scene) -> Plan:
        scene, camera = near(scene, scene.cameras[self.camera])
        return make_plan(
            scene,
            camera,
            free=self.changing,
            max_depth=self.depth,
            capacity=likely_room(camera),
            footprint=self.footprint,
        )

    def _picture(self, scene: Scene, plan: Plan):
        """A picture, and the most rays of a pass, in this thread: other frames have the other processors."""
        scene, camera = near(scene, scene.cameras[self.camera])
        tables, program = tables_of(scene, plan), plan.program
        numbers = (jnp.int32(number) for number in range(plan.passes))
        passes = [trace_pass(tables, camera, program, number, self.samples) for number in numbers]
        image, descendants = jax.block_until_ready(assembled(passes, camera))
        return image, descendants.max()
