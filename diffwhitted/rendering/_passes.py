"""The passes of a picture: traced, or recorded and replayed, with as much room as their rays need."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..image import gathered
from ..numerics._kept import kept
from ..numerics._workers import side_by_side
from ..scene import AbstractCamera, Scene, Tables
from ..tree import Beyond, Plan, Record, drawn, film_of, grid, record, replay, sample_places, tables_of, trace
from ._black import note_if_black


def trace_samples(
    tables: Tables,
    camera: AbstractCamera,
    plan: Plan,
    number: Int[Array, ""],
    samples: int = 1,
    beyond: Beyond | None = None,
):
    """One pass of the picture, (3, plan.pass_pixels), and for each sample how many rays other than camera rays it
    takes.

    With `beyond` there are three more channels: the most light that the branches that were not followed could bring.
    """

    def one_sample(draw):
        light, left, descendants = trace(tables, camera, plan, grid(plan, camera, number, draw), beyond)
        film = light.stacked(axis=0)
        return (film if left is None else jnp.concatenate([film, left.stacked(axis=0)])), descendants

    places = sample_places(max(plan.side, samples), camera.look_from.dtype)
    film, needed = jax.lax.map(one_sample, drawn(plan, places))
    return film.mean(axis=0), needed


trace_pass = kept(trace_samples)
"""The same as one compiled program; its plan is without names (see `Plan.program`)."""


def lowered_pass(scene: Scene, camera: AbstractCamera, plan: Plan, samples: int = 1, beyond: Beyond | None = None):
    """The program of `traced_passes`, lowered: to be compiled ahead of the first pass, or looked at."""
    return trace_pass.lower(tables_of(scene, plan), camera, plan.program, jnp.int32(0), samples, beyond)


def render_passes(scene: Scene, camera: AbstractCamera, plan: Plan, samples: int = 1):
    """The image (height, width, 3), differentiable, and whether the tree of one ray outgrew the plan's room.

    For traced values: a pass that needs more room is traced in parts, so that the picture is right all the same.
    """
    return _render_passes(tables_of(scene, plan), camera, plan.program, samples)


@eqx.filter_jit
def _render_passes(tables: Tables, camera: AbstractCamera, plan: Plan, samples: int):
    def one_sample(number, draw):
        light, lost = film_of(plan, (tables, camera, grid(plan, camera, number, draw)))
        return light.stacked(axis=0), lost

    def one_pass(number):
        places = sample_places(max(plan.side, samples), camera.look_from.dtype)
        film, lost = jax.lax.map(lambda draw: one_sample(number, draw), drawn(plan, places))
        return film.mean(axis=0), lost.any()

    film, lost = jax.lax.map(one_pass, _pass_numbers(plan))
    return gathered(film, camera.height, camera.width), lost.any()


def traced_passes(scene: Scene, camera: AbstractCamera, plan: Plan, samples: int = 1, beyond: Beyond | None = None):
    """The image, side by side on all processors, and the rays other than camera rays of each pass and sample."""
    image, needed = _traced_passes(tables_of(scene, plan), camera, plan.program, samples, beyond)
    note_if_black(scene, camera, plan, image)
    return image, needed


def _traced_passes(tables: Tables, camera: AbstractCamera, plan: Plan, samples: int, beyond: Beyond | None):
    passes = side_by_side(
        lambda number: trace_pass(tables, camera, plan, number, samples, beyond), list(_pass_numbers(plan))
    )
    return assembled(passes, camera)


def traced_with_room(scene: Scene, camera: AbstractCamera, plan: Plan, samples: int = 1, beyond: Beyond | None = None):
    """The same with as much room as the rays turn out to need."""
    tables, plan = tables_of(scene, plan), plan.program
    while True:
        image, descendants = _traced_passes(tables, camera, plan, samples, beyond)
        needed = int(descendants.max())
        if needed <= plan.capacity:
            note_if_black(scene, camera, plan, image)
            return image, descendants
        plan = plan.with_capacity(2 * needed)


@eqx.filter_jit
def assembled(passes, camera: AbstractCamera):
    """The picture of all passes, and the rays other than camera rays of each of them."""
    film, needed = (jnp.stack(part) for part in zip(*passes, strict=True))
    return gathered(film, camera.height, camera.width), needed


def record_passes(scene: Scene, camera: AbstractCamera, plan: Plan, place=None) -> Record:
    """The recorded trees of all passes, stacked."""
    return _record_passes(tables_of(scene, plan), camera, plan.program, _centre(scene) if place is None else place)


@kept
def _record_passes(tables: Tables, camera: AbstractCamera, plan: Plan, place) -> Record:
    return jax.lax.map(
        lambda number: record(tables, camera, plan, grid(plan, camera, number, place)), _pass_numbers(plan)
    )


def recorded_with_room(scene: Scene, camera: AbstractCamera, plan: Plan) -> tuple[Plan, Record]:
    """The same, and the plan with as much room as they turn out to need."""
    while True:
        trees = record_passes(scene, camera, plan)
        needed = int(np.max(trees.descendants))
        if needed <= plan.capacity:
            return plan, trees
        plan = plan.with_capacity(2 * needed)


def replay_passes(
    scene: Scene, camera: AbstractCamera, trees: Record, plan: Plan, place=None
) -> Float[Array, "height width 3"]:
    """The image of recorded trees, differentiable in `scene` and `camera`."""
    place = _centre(scene) if place is None else place
    return _replay_passes(tables_of(scene, plan), camera, trees, plan.program, place)


@eqx.filter_jit
def _replay_passes(tables: Tables, camera: AbstractCamera, trees: Record, plan: Plan, place):
    def one_pass(inputs):
        number, tree = inputs
        return replay(tables, camera, tree, plan, grid(plan, camera, number, place)).stacked(axis=0)

    film = jax.lax.map(one_pass, (_pass_numbers(plan), trees))
    return gathered(film, camera.height, camera.width)


def _pass_numbers(plan: Plan):
    return jnp.arange(plan.passes, dtype=jnp.int32)


def _centre(scene: Scene):
    return jnp.full(2, 0.5, scene.dtype)
