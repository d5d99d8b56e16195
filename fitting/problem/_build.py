"""From a scene and its targets to the problem of a fit, with all programs compiled."""

from collections.abc import Sequence
from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from diffwhitted.records import changed
from diffwhitted.scene import Scene, marks_of
from diffwhitted.tree import likely_room, make_plan, sample_places

from ._bounds import Bounds
from ._free_names import whole_names
from ._nameless import nameless_scene, nameless_unknowns, numbered_names
from ._priors import priors_of
from ._problem import Problem, any_moves, prepared
from ._sight import sights
from ._target import CheckedTarget, residual_count
from ._ties import Ties
from ._views import PART_PIXELS, PART_RAYS, view_of
from ._weighing import Weighing, first_weighing

SPARE = 1.4
"""Moving rays come to be more: so many times the likely room, for more room later would be another program."""


def build(
    scene: Scene,
    targets: tuple[CheckedTarget, ...],
    names: Sequence[str],
    ties: Ties,
    first: np.ndarray,
    samples: int,
    max_depth: int | None,
    footprint: int,
) -> tuple[Problem, Weighing]:
    """The problem, which begins at the leaders' values `first` and whose scene has the shots of the targets, and how
    much its residuals count.
    """
    unknowns = ties.all
    scene, total = changed(scene, shots=tuple(target.shot for target in targets)), float(residual_count(targets))
    weighing = first_weighing(targets, total)
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
    marks = [marks_of(scene, plan.at_work, outlines=plan.footprint > 0) for plan in plans]
    views = tuple(
        replace(
            view_of(sight, t.image, weight, places, 1 / max(footprint, 1), plan.program, mark),
            filter=t.shot.filter or "box",
        )
        for t, weight, plan, mark, sight in zip(targets, weighing.weights(targets), plans, marks, seen, strict=True)
    )
    views = prepared(plain, nameless, jnp.asarray(ties.matrix @ first, scene.dtype), views, moving)
    priors = priors_of(ties.leaders, 1 / total**0.5)
    matrix = ties.matrix if ties.any else None
    return Problem(plain, Bounds(ties.leaders), views, ties.leaders, nameless, matrix, priors), weighing
