"""The fit: from target pictures to material coefficients with uncertainties."""

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from diffwhitted._errors import FarFromOrigin
from diffwhitted.records import changed
from diffwhitted.scene import Scene, depth_number, is_traced, near, whole_number
from diffwhitted.tree import decide_effects, points_only, trees_or_points

from ._errors import FitError
from ._outcome import outcome, with_causes, with_runs
from ._prediction import with_prediction
from ._restricted import restricted
from ._result import FitResult, FitStep, WildPixel
from .judging._grey import grey_note, grey_only
from .judging._sharp import too_sharp, without_sharp
from .judging._wild import wild_note, wild_pixels
from .problem._bounds import Bounds
from .problem._build import build
from .problem._colour import coloured
from .problem._free_names import free_list, free_parameters, whole_names
from .problem._holding_out import held_out
from .problem._problem import any_moves
from .problem._shot_files import shots_of
from .problem._sought import Wishes, sought
from .problem._sums import require_start
from .problem._target import CheckedTarget, as_targets
from .problem._unknowns import Unknown, insert, start_values
from .problem._whole_pictures import shown_by
from .solving._alternatives import likely_causes
from .solving._lamps import best_lamps
from .solving._robust import LOSSES
from .solving._sampling import SIDE
from .solving._settling import Settled, settle
from .solving._solve import compile_solver


def fit(
    scene: Scene,
    targets=None,
    free: Sequence[str] = (),
    *,
    start: Mapping[str, float | Sequence[float]] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    prior: Mapping[str, tuple[float, float]] | None = None,
    ties: Mapping[str, str | tuple[float, str]] | None = None,
    at_most: Mapping[str, float] | None = None,
    colour: Sequence[str] = (),
    loss: str = "square",
    starts: int = 1,
    samples: int = 1,
    max_depth: int | None = None,
    footprint: int | None = None,
    max_steps: int = 100,
    coarse_to_fine: bool = True,
    hold_out: str | float | Sequence[str] | None = None,
    on_step: Callable[[FitStep], None] | None = None,
) -> FitResult:
    """Find the free numbers of a scene, its material coefficients first, that make the rendered scene equal the
    targets.

    - `targets`: a picture `(H, W, 3)` in linear Rec. 709 RGB, what `diffwhitted.read_image` gives, a `Target` (camera,
      mask, noise, shot), a mapping from camera names to pictures, or a sequence of targets; None: the shots of the
      scene, whose pictures are read.
    - `free`: names of `diffwhitted.parameters` ("glass.k_d", "light.key.position", "object.ball.centre.x") with
      wildcards: "*.k_d" means materials, all others begin with their family word ("light.*").
    - `start`, `bounds`: by name, with wildcards; otherwise the scene's values, and the bounds of the table or those
      that the scene suggests (see `_ranges`). A direction is free by two angles u and v in degrees, counted from the
      scene's.
      One number, or one for each component.
    - `prior`: what was known of a coefficient before, {"glass.refractive_index": (1.5, 0.02)}: mean and standard
      deviation of a Gaussian, beside the pictures. It counts in the standard errors and determines what they do not.
    - `ties`: {"mirror.k_h": "mirror.k_s"} or {"mirror.k_h": "0.5*mirror.k_s"}: the first follows the second, which
      is free.
    - `at_most`: {"mirror.k_s+mirror.k_t": 1}: the most that a sum may come to; of colours, in each channel.
    - `colour`: names of coefficients that are one number in the scene and are looked for as three. A free channel,
      such as "red.k_d.r", asks for it too.
    - `loss`: "square", or, where some pixels are not as the model has them, "huber", "cauchy" or "tukey": large
      residuals count for less. A few wild pixels that carry nearly all that is left over are left out in any case.
    - `starts`: how many starting points to try: the one above, the middle of the bounds, then a Sobol
      sequence over the bounds. The best end is returned.
    - `samples`: n x n rays a pixel.
    - `coarse_to_fine`: the first steps look at fewer samples of a large target (see `_stages`); `stages` of the
      result says
      at how many, and what that took.
    - `hold_out`: what the fit does not look at, to see how well it predicts it: the name of a shot (or several), or a
      share of the pixels (0.2, "20%"), in blocks; `held_out` of the result says.
    - `footprint`: k x k trees a pixel whose rays average what they meet over their share of it. Without it that is
      the scene's, or `samples`, where what is free moves rays, shadows or the edges of patterns: their derivative lies
      in the edges of the picture.

    Where any of these move, the ray tree is recorded anew in each step, the residuals are blurred at first
    (`_pyramid`), and the fit begins elsewhere than at `start` where a look along the refractive indices finds a better
    place (`_scan`). Minimises the sum over pixels of mask * ((render - target) / noise)^2 with optimistix's
    Levenberg-Marquardt on forward-mode Jacobians of the replayed ray tree (Levenberg 1944, Marquardt 1963).
    Standard errors are those of the linearised model with independent noise of one size, given or estimated
    from the residual. Raises `FitError` for input that cannot be used (`SceneError` for a max_depth).
    """
    begun = time.perf_counter()
    require_values(scene, targets, start, bounds, prior, ties, at_most)
    starts, samples, max_steps = (
        whole_number(value, name, error=FitError)
        for name, value in (("starts", starts), ("samples", samples), ("max_steps", max_steps))
    )
    max_depth = depth_number(max_depth)
    if loss not in (known := ("square", *LOSSES)):
        raise FitError(f"loss = {loss!r}; allowed is {', '.join(known)}")
    scene = coloured(scene, colour, free)
    targets, given = as_targets(scene, targets if targets is not None else shots_of(scene)), scene
    left_out, what = None, ""
    if hold_out is not None:
        targets, left_out, what = held_out(targets, hold_out)
    scene = near_the_first(changed(scene, shots=tuple(target.shot for target in targets)), targets)
    names, passed_over = free_parameters(
        scene, (*free_list(free), *(ties or {})), max_depth, {target.camera for target in targets}
    )
    wanted = sought(scene, names, Wishes(bounds or {}, prior or {}, ties or {}, at_most or {}))
    unknowns = wanted.all
    if given.keeps_digits:
        require_no_places(unknowns)
    first = start_values(scene, wanted.leaders, start)
    require_start(wanted.leaders, first)
    moving, wide = any_moves(unknowns), {target.shot.filter for target in targets} - {None}
    plain = footprint is None and not scene.footprint and samples == 1
    automatic = plain and not moving and not wide
    # A filter that is stated is one of pixels, and one that is wider than a pixel asks for more samples than trees.
    if plain and wide:
        samples = SIDE if not moving else 2 if wide != {"box"} else 1
    if footprint is None:
        footprint = scene.footprint or (samples if moving else 0)
    sampling = None if automatic else "pixel" if footprint or samples > 1 else "points"
    footprint, samples = able(scene, unknowns, footprint, samples)
    problem, weighing = build(scene, targets, names, wanted, first, samples, max_depth, footprint)
    compile_solver(problem, first)
    begin, relit = best_lamps(scene, targets, problem, first)
    seconds_compile, ends = time.perf_counter() - begun, []
    for point in _starting_points(begin, wanted.leaders, starts):
        ends.append(
            settle(
                problem,
                targets,
                weighing,
                point,
                sampling=sampling,
                max_steps=max_steps,
                coarse_to_fine=coarse_to_fine,
                on_step=on_step,
                loss=loss,
            )
        )
        if ends[-1].solution.interrupted:
            break
    end = min(ends, key=lambda end: end.remainder)
    best, problem = end.solution, end.problem
    effects = tuple(
        (d.name, d.on, d.why) for d in decide_effects(scene, whole_names(scene, names), max_depth, footprint)
    )
    notes = grey_note(grey_only(scene, problem, targets, best.values))
    if relit:
        notes += (f"looked for from where the pictures have the lamp, not from the start: {', '.join(relit)}",)
    notes += tuple(f"{name} left as it is: {why}" for name, why in passed_over)
    notes += tuple(remark for target in targets for remark in target.notes)
    wild = _wild(targets, end)
    notes = (*wild_note(wild, len(targets) > 1), *notes)
    result = outcome(scene, end.targets, end, first, effects, notes)
    unrestricted = not (wanted.any or problem.priors is not None or any(u.sums for u in wanted.leaders))
    if result.misfit and unrestricted and not best.interrupted:
        found = likely_causes(scene, end.targets, names, end, best.values, max_depth, footprint)
        result = with_causes(result, found)
    result = without_sharp(restricted(result, scene, wanted), too_sharp(problem, best.values))
    if left_out is not None:
        result = with_prediction(result, left_out, what, scene)
    if given.keeps_digits:
        whole = changed(given, shots=scene.shots)
        result = replace(
            result,
            scene=insert(whole, unknowns, np.asarray([c.value for c in result.coefficients]).astype(given.dtype)),
        )
    if not given.shots and not any(u.parameter.family == "shot" for u in unknowns):
        result = replace(result, scene=changed(result.scene, shots=()))
    result = replace(result, wild=wild, loss=loss)
    return with_runs(result, [end.solution for end in ends], seconds_compile)


def _wild(targets: tuple[CheckedTarget, ...], end: Settled) -> tuple[WildPixel, ...]:
    """The wild pixels of the targets as they were given."""
    left_out = [(t.mask > 0) & (used.mask == 0) for t, used in zip(targets, end.targets, strict=True)]
    eps = float(jnp.finfo(end.problem.scene.dtype).eps)
    return wild_pixels(targets, left_out, shown_by(targets, end.solution.films), eps)


def require_no_places(unknowns) -> None:
    """Raise `FitError` where a place is free in a scene that is far from the origin."""
    for unknown in unknowns:
        row = unknown.parameter.row
        if row.unit == "m" and row.kind in ("vector", "vectors") or row.name == "offset":
            raise FitError(
                f"--free {unknown.name}: the scene is far from the origin of its coordinates, where float32 does not "
                "resolve places; move the scene near to the origin, or fit in float64"
            )


def near_the_first(scene: Scene, targets: tuple[CheckedTarget, ...]) -> Scene:
    """The scene as it is traced: relative to the camera of the first target, where that is far from the origin."""
    placed, _ = near(scene, scene.cameras[targets[0].camera])
    for target in targets:
        if placed.cameras[target.camera].is_far:
            warnings.warn(
                f"camera {target.camera!r} is so far from camera {targets[0].camera!r} that float32 blurs what it "
                "sees; fit them one after the other, or in float64",
                FarFromOrigin,
                stacklevel=3,
            )
    return placed


def require_values(*given) -> None:
    """Raise `FitError` where something has no value yet, under `jit`, `grad` or `vmap`: a fit decides by values."""
    if any(map(is_traced, jax.tree.leaves(given))):
        raise FitError(
            "fit: scene, targets, start or bounds are traced, so they have no values to fit; call fit outside "
            "jax.jit, jax.grad and jax.vmap, one target after the other. To differentiate residuals of your own, trace "
            "diffwhitted.render with a plan"
        )


def able(scene: Scene, unknowns: tuple[Unknown, ...], footprint: int, samples: int) -> tuple[int, int]:
    """Footprint and samples, of which something in the scene may know points only.

    Raises `FitError` where what is free moves edges then: points do not see them move.
    """
    if (what := points_only(scene)) is None:
        return footprint, samples
    moving = next((u.name for u in unknowns if any_moves((u,))), None)
    if moving is not None:
        raise FitError(
            f"free: {moving} moves edges in the picture, and {what} knows points only, which do not see them move; "
            f"fix {moving} at a known value, or leave {what} out of the scene"
        )
    footprint, points = trees_or_points(scene, footprint)
    return footprint, max(samples, points)


def _starting_points(first: np.ndarray, unknowns, starts: int) -> list[np.ndarray]:
    points = [first]
    if starts > 1:
        from scipy.stats import qmc  # slow to import, and most fits have one start

        bounds = Bounds(unknowns)
        shares = np.concatenate(
            [
                np.full((1, len(unknowns)), 0.5),
                qmc.Sobol(len(unknowns), rng=0).random_base2(max(1, (starts - 1).bit_length())),
            ]
        )
        points += [
            np.asarray(bounds.values(jnp.asarray(np.arcsin(np.sqrt(s)))))
            for s in np.clip(shares[: starts - 1], 0.01, 0.99)
        ]
    return points
