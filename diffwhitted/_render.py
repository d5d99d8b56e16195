"""The door: from scene and camera to image."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ._errors import CapacityError, SceneError
from .accuracy import choose
from .rendering._antialias import antialias as adaptive
from .rendering._passes import recorded_with_room, render_passes, traced_passes, traced_with_room
from .rendering._unforeseen import poisoned, unforeseen
from .scene import AbstractCamera, Scene, depth_number, find_parameter, is_traced, near, whole_number
from .tree import Plan, likely_room, make_plan, unmeasured_plan


def render(
    scene: Scene,
    camera: AbstractCamera,
    *,
    plan: Plan | None = None,
    samples: int = 1,
    max_depth: int | None = None,
    footprint: int | None = None,
    cutoff: float | None = None,
    antialias: float | None = None,
    tolerance: float | None = None,
) -> Float[Array, "height width 3"]:
    """The image of a scene: linear Rec. 709 RGB, scene-referred, row 0 on top.

    `samples` is the number of samples along each side of a pixel (n x n rays on a regular grid, averaged);
    `footprint` = k traces k x k trees in their place whose rays average what they meet over their share of the
    pixel (0: none); a branch that would carry less than `cutoff` in every channel is not followed (0: all are).
    These two and `max_depth` replace the scene's. `antialias` is the threshold of Whitted's adaptive scheme in place of
    samples or footprint (see `antialias`; not where values are traced). `tolerance` (RMSE, such as 1/255) stands in
    place of all of them: the cheapest that meet it are looked for (see `choose`). Works under `jit`, `grad`, `jvp`
    and `vmap`. Derivatives in all arrays of `scene` and `camera` are those of the recorded tree: exact for the
    coefficients that move no ray. For those that do, such as a refractive index, they see the motion of edges only
    with a footprint.

    Without a `plan` one is made for this call. Inside `jit` (or where values are traced) it has every effect that a
    traced number may call for; `plan=diffwhitted.plan(scene, camera)` leaves out what the scene does not. Raises
    `SceneError` for a plan that does not fit the scene and camera, and `CapacityError` where its room for rays is too
    small; no ray is dropped in silence. Where values are traced nobody can be told: numbers that call for more than
    the plan has make the whole picture and all its derivatives NaN, and a pass with too little room goes in parts.
    """
    if tolerance is not None:
        if (
            plan is not None
            or samples != 1
            or any(option is not None for option in (max_depth, footprint, cutoff, antialias))
        ):
            raise SceneError(
                "tolerance beside plan, samples, max_depth, footprint, cutoff or antialias, which it stands in "
                "place of; give it alone"
            )
        return jnp.asarray(choose(scene, camera, tolerance=tolerance).measured.image)
    scene = scene.with_cutoff(cutoff)
    scene, camera = near(scene, camera)
    samples, max_depth, given = whole_number(samples, "samples"), depth_number(max_depth), plan is not None
    for option, value in (("max_depth", max_depth), ("footprint", footprint)):
        if given and value is not None:
            raise SceneError(
                f"{option} = {value} beside a plan, which has its own; give it to diffwhitted.plan instead"
            )
    traced = any(map(is_traced, jax.tree.leaves((scene, camera))))
    if antialias is not None:
        if given or samples > 1 or footprint or traced:
            other = (
                "a plan"
                if given
                else f"samples = {samples}"
                if samples > 1
                else f"footprint = {footprint}"
                if footprint
                else "traced values"
            )
            raise SceneError(
                f"antialias = {antialias!r} with {other}; allowed is one way to antialias, and this one only "
                "outside jit, grad and vmap"
            )
        return jnp.asarray(adaptive(scene, camera, antialias, max_depth=max_depth).image)
    if plan is not None:
        _check(plan, scene, camera, traced)
    elif traced:
        plan = unmeasured_plan(scene, camera, max_depth=max_depth, footprint=footprint)
    else:
        plan = make_plan(scene, camera, max_depth=max_depth, capacity=likely_room(camera), footprint=footprint)
    if samples > 1 and plan.footprint:
        raise SceneError(
            f"samples = {samples} with footprint = {plan.footprint}; allowed is one of the two: footprint = k traces "
            "k x k trees a pixel, footprint = 0 with samples = n traces n x n points"
        )
    if traced:
        image, lost = render_passes(scene, camera, plan, samples)
        wrong = lost | unforeseen(scene, plan, camera) if given else lost
        return poisoned(image, eqx.filter((scene, camera), eqx.is_inexact_array), wrong)
    if not given:
        return traced_with_room(scene, camera, plan, samples)[0]
    image, descendants = traced_passes(scene, camera, plan, samples)
    if int(descendants.max()) > plan.capacity:
        raise CapacityError(_too_small(plan))
    return image


def plan(
    scene: Scene,
    camera: AbstractCamera,
    *,
    free: tuple[str, ...] = (),
    max_depth: int | None = None,
    footprint: int | None = None,
) -> Plan:
    """A plan with measured room for the rays of this scene and camera, with a tenth to spare.

    `free` names coefficients ("glass.k_s") whose derivative is wanted although they may be zero now; `max_depth`
    and `footprint` replace the scene's. Raises `SceneError` for a name that the scene does not have, and inside
    `jit`, where there is nothing to measure.
    """
    if any(map(is_traced, jax.tree.leaves((scene, camera)))):
        raise SceneError(
            "plan: the values of the scene or camera are traced, so there is nothing to measure; "
            "call diffwhitted.plan outside jit, grad or vmap, and pass the plan in"
        )
    for name in free:
        find_parameter(scene, name)
    max_depth = depth_number(max_depth)
    scene, camera = near(scene, camera)
    guess = make_plan(scene, camera, free=free, max_depth=max_depth, capacity=likely_room(camera), footprint=footprint)
    guess, trees = recorded_with_room(scene, camera, guess)
    return guess.with_capacity(int(1.1 * int(np.max(trees.descendants))))


def _check(plan: Plan, scene: Scene, camera: AbstractCamera, traced: bool):
    """A plan that leaves out what the scene calls for would give a wrong image, or a derivative of 0, without a word.

    A traced coefficient may be anything, so the plan must have its effect. Where everything is traced nothing is known.
    """
    asked = plan
    coefficients = [is_traced(leaf) for leaf in jax.tree.leaves(scene.materials)]
    elsewhere = any(
        map(is_traced, jax.tree.leaves((scene.objects, scene.lights, scene.background, scene.ambient, camera)))
    )
    if not traced or not (elsewhere or all(coefficients)):
        asked = make_plan(scene, camera, max_depth=plan.max_depth, capacity=plan.capacity, footprint=plan.footprint)
    wrong = plan.shortfall(replace(asked, picture=(camera.width, camera.height)))
    if wrong:
        advice = "; name a coefficient that is zero but traced in plan(..., free=(...))" if traced else ""
        raise SceneError(f"plan: {wrong}; make one with diffwhitted.plan(scene, camera){advice}")


def _too_small(plan: Plan) -> str:
    return (
        f"the ray tree needs more room than the plan's {plan.capacity} rays a pass; make a plan for this scene "
        "with diffwhitted.plan(scene, camera), lower max_depth, or set fewer of k_s and k_t above zero"
    )
