"""From a scene and its targets to the problem of a fit, with all programs compiled."""

from collections.abc import Sequence
from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from diffwhitted.records import changed
from diffwhitted.scene import Scene, marks_of
from diffwhitted.tree import likely_room, make_plan, sample_places

from ..judging._rest import UNIT, residual_count
from ._bounds import Bounds
from ._free_names import whole_names
from ._nameless import nameless_scene, nameless_unknowns, numbered_names
from ._problem import Problem, any_moves, prepared
from ._sight import sights
from ._target import CheckedTarget
from ._unknowns import Unknown
from ._views import PART_PIXELS, PART_RAYS, view_of

SPARE = 1.4
"""Moving rays come to be more: so many times the likely room, for more room later would be another program."""


def build(
    scene: Scene,
    targets: tuple[CheckedTarget, ...],
    names: Sequence[str],
    unknowns: tuple[Unknown, ...],
    first: np.ndarray,
    samples: int,
    max_depth: int | None,
    footprint: int,
) -> tuple[Problem, float]:
    """The problem, whose scene has the shots of the targets, and the number by which its mean square becomes the sum of
    squares.
    """
    scene, total = changed(scene, shots=tuple(target.shot for target in targets)), float(residual_count(targets))
    moving, places = any_moves(unknowns), sample_places(footprint or samples, scene.dtype)
    called, plans = numbered_names(scene), []
    for target in targets:
        camera = scene.cameras[target.camera]
        plan = make_plan(
            scene,
            camera,
            free=whole_names(scene, names),
            max_depth=max_depth,
            capacity=int(likely_room(camera, PART_PIXELS) * (SPARE if moving else 1)),
            footprint=footprint,
            pass_of=PART_PIXELS,
            block_of=PART_RAYS,
        )
        # One tree may serve the whole fit, whatever its coefficients become: every branch of it is followed.
        plans.append(replace(plan, zero_weights=False))
    cut_off = any(plan.effects.cutoff for plan in plans)
    plain, nameless = nameless_scene(scene, called), nameless_unknowns(unknowns, called, cut_off)
    burning = [None if t.shot.lights is None else [called["light"][name] for name in t.shot.lights] for t in targets]
    seen = sights(plain, [called["camera"][t.camera] for t in targets], burning, nameless)
    marks = [marks_of(scene, plan.at_work) for plan in plans]
    views = tuple(
        view_of(sight, t.image, weights(t, total), places, 1 / max(footprint, 1), plan.program, mark)
        for t, plan, mark, sight in zip(targets, plans, marks, seen, strict=True)
    )
    views = prepared(plain, nameless, jnp.asarray(first, scene.dtype), views, moving)
    return Problem(plain, Bounds(unknowns), views, unknowns, nameless), total


def weights(target: CheckedTarget, total: float, spread: np.ndarray | float = UNIT) -> np.ndarray:
    """Of each channel of each pixel, (height, width, 3): its residual times this has a square of the right weight.

    `spread`: standard deviation of what is left over, where no noise is given. Equal channels count as one.
    """
    deviation = spread if target.noise is None else target.noise.deviation(target.image)
    weight = np.sqrt(target.mask / (3 / target.channels))[..., None] / deviation / np.sqrt(total)
    return np.broadcast_to(weight, target.image.shape)
