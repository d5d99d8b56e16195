"""The fit of a texture: a map of a coefficient, texel by texel, with the standard error of each."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from jaxtyping import Bool, Float

from diffwhitted.records import nearest_name
from diffwhitted.scene import Scene, maps, replace_parameter
from diffwhitted.tree import idle

from ._errors import FitError
from .judging._banded import Banded
from .problem._map_view import MapView
from .problem._shot_files import shots_of
from .problem._target import as_targets
from .solving._map_solve import MapSolution, normal_matrix, sighted, solve_map

LARGEST_GAIN = 1e3
"""A texel in which the noise of the pixels would stand so many times over is not determined, and called unseen."""
DOUBTFUL = 6.0
"""Standard deviations by which chi^2 may exceed its mean before the model is wrong."""


@dataclass(frozen=True, eq=False)
class TextureFit:
    """What the pictures say of the texels of a texture.

    texels: (height, width, 3), row 0 on top; those that are unseen stay near their start. scene: with these texels, and
    0 where one is below.
    standard_errors: (height, width, 3), NaN where unseen. seen: (height, width), whether the pictures determine the
    texel.
    residual: root mean square of picture - target, over the pixels that count. noise: the standard deviation of a
    pixel, of what the fit left over; NaN where it was stated.
    left_out: pixels that see the map in places too far apart to be told from each other: they count in the texels and
    not in the standard errors, which are larger for it.
    pictures: what each target looks like now, by name.
    status: "converged", "misfit" (more is left than the stated noise can be) or "not_converged".
    """

    texture: str
    texels: Float[np.ndarray, "height width 3"]
    standard_errors: Float[np.ndarray, "height width 3"]
    seen: Bool[np.ndarray, "height width"]
    scene: Scene
    status: str
    message: str
    residual: float
    noise: float
    left_out: int
    steps: int
    seconds: float
    pictures: dict[str, Float[np.ndarray, "rows columns 3"]]


def fit_texture(
    scene: Scene,
    texture: str,
    targets=None,
    *,
    max_depth: int | None = None,
    footprint: int | None = None,
    max_steps: int = 20,
    on_step: Callable[[int, float], None] = lambda step, residual: None,
) -> TextureFit:
    """Find the texels of an image texture that make the rendered scene equal the targets; all else is known.

        fit_texture(scene, "wall", {"left": picture, "right": other}).scene

    - `texture`: the name of an image texture that a material of the scene wears. Its texels are where the fit starts.
    - `targets`: as those of `fit`; None: the shots of the scene.
    - `footprint`: 0 for targets of points, 1 for averages over pixels; None: the scene's.
    - `on_step` is told of each step, with the root mean square of the weighted residuals.

    Gauss and Newton's method: one step where the pictures are linear in the texels, as those of k_d are where the map
    does not light or mirror itself. A standard error is the root of the diagonal of the inverse normal matrix, exactly,
    times the noise: what the targets state, or else what is left over. Raises `FitError` for a texture that is not
    there, is no image, or is worn by nothing that is seen.
    """
    start = perf_counter()
    parameter = _map_of(scene, texture)
    footprint = scene.footprint if footprint is None else footprint
    if footprint not in (0, 1):
        raise FitError(f"footprint = {footprint}; of a texture it may be 0 (points) or 1 (one filtered tree a pixel)")
    why = idle(scene, parameter, [parameter.name], max_depth)
    if why:
        raise FitError(f"texture {texture!r} has no effect on the image: {why}")
    checked = as_targets(scene, shots_of(scene) if targets is None else targets)
    texels = np.asarray(parameter.value(scene), np.float64)
    views = [MapView(scene, texture, target, footprint, max_depth).recorded(texels.astype(scene.dtype))
             for target in checked]  # fmt: skip
    solution = solve_map(views, texels, max_steps, on_step)
    stated = checked[0].noise is not None
    errors, seen, variance, freedom = _judged(views, solution, stated)
    if not seen.any():
        raise FitError(f"texture {texture!r}: no pixel of the targets sees it; give pictures that show it")
    status, message = _status(solution, stated, variance, freedom)
    count, left_out = int(seen.sum()), sum(int((~rows.known).sum()) for rows in solution.rows)
    message = f"{message}; {count:,} of {seen.size:,} texels are seen"
    if left_out:
        message += f"; {left_out:,} pixels see the map in several places and do not count in the standard errors"
    left = [(v.target - p)[v.weight > 0] for v, p in zip(views, solution.pictures, strict=True)]
    found = solution.texels.astype(scene.dtype)
    return TextureFit(
        texture, found, errors, seen, replace_parameter(scene, parameter.name, np.maximum(found, 0)), status, message,
        float(np.sqrt(np.mean(np.concatenate(left) ** 2))), float(np.sqrt(variance)) if not stated else float("nan"),
        left_out, solution.steps, perf_counter() - start,
        {view.name: picture for view, picture in zip(views, solution.pictures, strict=True)},
    )  # fmt: skip


def _map_of(scene: Scene, texture: str):
    """The texels of a texture. Raises `FitError` where there is none of that name."""
    there = {parameter.owner: parameter for parameter in maps(scene)}
    if texture not in there:
        known = ", ".join(there) or "none at all"
        raise FitError(
            f"texture {texture!r} is no image texture of the scene; there is {known}.{nearest_name(texture, there)}"
        )
    for name, material in scene.materials.items():
        if key := next((key for key, worn in material.relief if worn == texture), None):
            raise FitError(
                f"texture {texture!r} is the {key} of material {name!r}, and normals move rays; only a texture that "
                "multiplies a coefficient can be found texel by texel. Free the material's height_scale instead"
            )
    return there[texture]


def _judged(views, solution: MapSolution, stated: bool):
    """Standard errors, which texels are seen, the variance of unit weight, and its degrees of freedom."""
    height, width = solution.texels.shape[:2]
    gains, seen = np.full((height * width, 3), np.nan), np.ones(height * width, bool)
    for channel in range(3):
        normal = normal_matrix(views, solution.rows, channel)
        there = np.flatnonzero(sighted(normal))
        mine = np.zeros(height * width, bool)
        if there.size:
            inverse = np.maximum(Banded.of(normal[there][:, there]).inverse_diagonal(), 0)
            gains[there, channel] = np.sqrt(inverse)
            mine[there] = gains[there, channel] * np.sqrt(normal.diagonal().max()) < LARGEST_GAIN
        seen &= mine
    # Take the noise from the pixels that show the map.
    squares, count = 0.0, 0
    for view, rows, picture in zip(views, solution.rows, solution.pictures, strict=True):
        shows = (np.diff(rows.channels[0].indptr) > 0).reshape(view.size) | ~rows.known
        counts = (view.weight > 0) & shows[..., None]
        squares += float(((view.weight * (view.target - picture))[counts] ** 2).sum())
        count += int(counts.sum())
    freedom = count - 3 * int(seen.sum())
    variance = squares / freedom if freedom > 0 else np.nan
    scale = np.sqrt(max(variance, 1.0)) if stated else np.sqrt(variance)
    errors = np.where(seen[:, None], gains * scale, np.nan).reshape(height, width, 3)
    return errors, seen.reshape(height, width), variance, freedom


def _status(solution: MapSolution, stated: bool, variance: float, freedom: int) -> tuple[str, str]:
    """How it ended, and a sentence on it."""
    if not solution.converged:
        return "not_converged", f"the texels still moved after {solution.steps} steps; allow more (max_steps)"
    if stated and variance > 1 + DOUBTFUL * np.sqrt(2 / freedom):
        return "misfit", (
            f"what is left over is {np.sqrt(variance):.3g} times the stated noise: something in the scene is not as it "
            "was, and the standard errors are larger by that factor"
        )
    return "converged", f"converged in {solution.steps} steps"
