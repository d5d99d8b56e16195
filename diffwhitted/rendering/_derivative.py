"""A picture with its derivative in one number, by more trees where the derivative is largest.

A footprint is linear over its pixel. Where the map from the picture to a surface is curved, or an edge runs along the
side of a pixel, the derivative of one tree is off, and nearly all of that error lies in the few pixels with the
largest derivatives. These are traced a second time, by `SIDE` x `SIDE` trees each.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..image import gathered
from ..numerics._kept import kept
from ..numerics._workers import side_by_side
from ..scene import AbstractCamera, Scene, Tables, depth_number, marks_of, near, nearest_name, tabulate
from ..tree import Plan, Samples, drawn, grid, likely_room, make_plan, record, replay, sample_places
from ._sample_lists import film_of, traced_list

SIDE = 2
MOST_PIXELS = 1 / 15
"""Of the picture: so many pixels at most are refined."""


@dataclass(frozen=True, eq=False)
class Derivative:
    """A picture and how it changes with one number."""

    image: np.ndarray
    """(height, width, 3), linear Rec. 709 RGB."""
    slope: np.ndarray
    """(height, width, 3), per unit of the number."""
    refined: np.ndarray
    """(height, width), true where more trees were traced."""
    rays: int


def derivative(
    make: Callable[[Float[Array, "..."]], Scene],
    value,
    camera: AbstractCamera | str,
    *,
    free: tuple[str, ...] = (),
    max_depth: int | None = None,
    footprint: int = 1,
    refine: bool = True,
) -> Derivative:
    """The picture of `make(value)` and its derivative in `value`, a number or an array whose entries change together.

        derivative(lambda n: replace_coefficient(scene, "glass.refractive_index", n), 1.5, camera)

    - `camera`: as it stands, or by its name in the scene: then its rays move with it where `make` moves it.
    - `free`: coefficients whose derivative is wanted although they may be zero ("glass.k_s").
    - `footprint`: k x k filtered trees a pixel; 0 traces points, whose derivative does not see edges move.
    - `refine`: trace 2 x 2 trees for each of them in the pixels with the largest derivatives, a fifteenth of the
      picture at most. Only with a footprint.

    `make` may change anything in the scene: coefficients, places, sizes, lights, cameras. Forward mode (Igehy 1999 for
    the footprints; see `tree`). Raises `SceneError` for a footprint or depth that is not one, and `CapacityError` where
    the tree outgrows the memory.
    """
    value = jnp.asarray(value, float)
    given = make(value)
    if not isinstance(given, Scene):
        raise SceneError(f"derivative: make(value) gave a {type(given).__name__}; allowed is a Scene")
    about = _seen_by(given, camera)
    scene, tangent = eqx.filter_jvp(lambda value: near(make(value), about)[0], (value,), (jnp.ones_like(value),))
    camera, turn = _camera(scene, tangent, camera, near(given, about)[1])
    plan = make_plan(
        scene, camera, free=free, max_depth=depth_number(max_depth), capacity=likely_room(camera), footprint=footprint
    )
    pixels, samples = camera.width * camera.height, _regular(plan, camera)
    marks = marks_of(scene, free, shared=plan.shared, outlines=plan.footprint > 0)
    tables, along = eqx.filter_jvp(lambda scene: tabulate(scene, marks), (scene,), (tangent,))
    program = partial(_pass, (tables, camera), (along, turn), plan.program)
    films, counts = zip(*side_by_side(lambda one: film_of(program, plan, one), samples), strict=True)
    films, rays = np.stack(films), sum(counts)
    per_pixel = len(samples) // plan.passes
    whole = films.reshape(per_pixel, plan.passes, 2, 3, -1).mean(axis=0)
    image, slope = (
        np.array(gathered(jnp.asarray(whole[:, part]), camera.height, camera.width)).reshape(pixels, 3)
        for part in (0, 1)
    )
    chosen = _largest(slope) if refine and plan.footprint and plan.draws == 1 else np.zeros(0, int)
    if chosen.size:
        side = SIDE * plan.footprint
        inside = np.asarray(sample_places(side, scene.dtype))
        column, row = (
            (at[:, None] + inside[:, axis]).reshape(-1)
            for axis, at in enumerate((chosen % camera.width, chosen // camera.width))
        )
        finer, more = traced_list(program, plan, column, row, 1 / side, scene.dtype)
        image[chosen], slope[chosen] = finer.reshape(2, 3, chosen.size, side**2).mean(axis=-1).transpose(0, 2, 1)
        rays += more
    refined = np.zeros(pixels, bool)
    refined[chosen] = True
    picture = camera.height, camera.width
    return Derivative(image.reshape(*picture, 3), slope.reshape(*picture, 3), refined.reshape(picture), rays)


def _regular(plan: Plan, camera: AbstractCamera) -> list[Samples]:
    """The passes of the whole picture, for each of the trees of a pixel."""
    draws = drawn(plan, sample_places(plan.side, camera.look_from.dtype))
    each = [jax.tree.map(lambda a, k=k: a[k], draws) for k in range(len(draws.number))]
    return [grid(plan, camera, jnp.int32(number), draw) for draw in each for number in range(plan.passes)]


def _largest(slope: np.ndarray) -> np.ndarray:
    """The pixels, counted row by row, with the largest derivatives, none where it is zero."""
    size = np.square(slope, dtype=np.float64).sum(axis=-1)
    most = min(max(1, int(MOST_PIXELS * size.size)), np.count_nonzero(size))
    return np.sort(np.argpartition(-size, most - 1)[:most]) if most else np.zeros(0, int)


def _seen_by(scene: Scene, camera: AbstractCamera | str) -> AbstractCamera:
    """The camera itself. Raises `SceneError` for a name that the scene does not have."""
    if not isinstance(camera, str):
        return camera
    if camera not in scene.cameras:
        known = ", ".join(scene.cameras) or "none at all"
        raise SceneError(f"derivative: no camera {camera!r}; there is {known}.{nearest_name(camera, scene.cameras)}")
    return scene.cameras[camera]


def _camera(scene: Scene, tangent, asked: AbstractCamera | str, placed: AbstractCamera) -> tuple[AbstractCamera, Any]:
    """The camera, and how it changes; one that is none of the scene's, `placed` near the scene, does not."""
    if isinstance(asked, str):
        return scene.cameras[asked], tangent.cameras[asked]
    return placed, jax.tree.map(lambda a: None, placed)


@kept
def _pass(seen: tuple[Tables, AbstractCamera], change, plan: Plan, samples: Samples):
    """One pass of tables and camera: value and derivative (2, 3, pixels), and the number of descendants."""
    tree = record(*seen, plan, samples)

    def film(tables, camera):
        return replay(tables, camera, tree, plan, samples, forward=True).stacked(axis=0)

    return jnp.stack(eqx.filter_jvp(film, seen, change)), tree.descendants
