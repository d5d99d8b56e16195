"""What goes into a picture: overhead, intersection, shading, as Whitted breaks it down (Whitted 1980, section 4)."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from ..scene import AbstractCamera, Scene
from ..tree import Plan, drawn, grid, record, replay, sample_places, tables_of
from ._programs import Program, compiled


@dataclass(frozen=True)
class Work:
    """Parts of the time of a picture, which add up to 1; one that is below 0 cannot be told from nothing.

    Whitted's picture of few objects took 0.13, 0.75 and 0.12, those of many more than 0.95 in the search.
    """

    overhead: float
    """To set out along rays that are known, to place the points and normals where they end, to keep the tree."""
    intersection: float
    """To search for the surface that each ray meets, and for what stands between points and lights."""
    shading: float
    """To compute and to add up the light."""


def work_of(whole: np.ndarray, search: np.ndarray, walk: np.ndarray) -> Work:
    """The parts, from the seconds (rounds,) of the picture, of its search and of its way along known rays.

    The search walks too; what the picture takes beyond it is shading. Medians over the rounds.
    """
    overhead, shading = float(np.median(walk / whole)), 1 - float(np.median(search / whole))
    return Work(overhead, 1 - overhead - shading, shading)


def work_programs(scene: Scene, camera: AbstractCamera, plan: Plan) -> dict[str, Program]:
    """Two parts of the picture as programs: the search and all that it needs, and the way along known rays alone."""
    draws = drawn(plan, sample_places(plan.side, scene.dtype))
    tables, plan = tables_of(scene, plan), plan.program
    numbers = list(jnp.arange(plan.passes, dtype=jnp.int32))

    def search(given):
        tables, number = given
        return jax.lax.map(lambda draw: record(tables, camera, plan, grid(plan, camera, number, draw)), draws)

    searching = compiled(search, [(tables, number) for number in numbers])

    def walk(given):
        tables, number, trees = given

        def points(sample):
            tree, draw = sample
            samples = grid(plan, camera, number, draw)
            return replay(
                tables, camera, tree, plan, samples, lambda tables, plan, nodes, at, needed: at.point, forward=True
            ).stacked(axis=0)

        return jax.lax.map(points, (trees, draws))

    return {
        "search": searching,
        "walk": compiled(
            walk, [(tables, number, trees) for number, trees in zip(numbers, searching.run(), strict=True)]
        ),
    }
