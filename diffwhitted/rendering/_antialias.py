"""Antialiasing by Whitted's scheme: more samples where the corners of a pixel differ (Whitted 1980, section 3).

A pixel is the square between four samples at its corners, which it shares with its neighbours. Where their colours
differ by more than a threshold, or something small may lie between them, the square is divided into four, and these
again, down to `LEVELS` times. The pixel is the sum of the means over its squares, weighted by their areas. Small
objects: Whitted gives bounding spheres a least radius, so that some ray meets them; here a ray that passes by a
bounding sphere closer than the distance of two samples, of an object smaller than that, has its squares divided.
"""

from dataclasses import dataclass
from functools import partial

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._errors import SceneError
from ..numerics._kept import kept
from ..scene import AbstractCamera, Scene, Tables, depth_number, near
from ..tree import Plan, Samples, averaged, likely_room, make_plan, tables_of, trace_beside_small
from ._sample_lists import packed_pass, traced_list

LEVELS = 3
"""A side of a pixel is divided into at most 2**3 = 8."""


@dataclass(frozen=True, eq=False)
class Antialiased:
    """A picture, and what it took."""

    image: np.ndarray
    """(height, width, 3), linear Rec. 709 RGB."""
    squares: np.ndarray
    """(height, width): into how many squares each pixel was divided, 1 to 64."""
    samples: int
    """Camera rays in all."""
    rays: int


def antialias(
    scene: Scene,
    camera: AbstractCamera,
    threshold: float,
    *,
    levels: int = LEVELS,
    max_depth: int | None = None,
    cutoff: float | None = None,
) -> Antialiased:
    """The picture by Whitted's adaptive scheme.

    `threshold`: the largest difference between corners, in any channel of linear RGB, at which a square is not divided.
    Not under `jit`, as the picture decides where rays go. Raises `SceneError` for options that are none and
    `CapacityError` where the tree outgrows the memory.
    """
    check_threshold(threshold)
    if isinstance(levels, bool) or not isinstance(levels, int) or not 0 <= levels <= 6:
        raise SceneError(f"levels = {levels!r}; allowed is a whole number from 0 (corners only) to 6")
    scene, camera, plan = _prepared(scene, camera, max_depth, cutoff)
    width, height, finest = camera.width, camera.height, 2**levels
    trace = _Tracer(scene, camera, plan, finest)
    row, column = np.mgrid[: height + 1, : width + 1].reshape(2, -1) * finest
    found = trace(row, column, finest).reshape(height + 1, width + 1, 4)
    corners = np.stack([found[:-1, :-1], found[:-1, 1:], found[1:, :-1], found[1:, 1:]], axis=2).reshape(-1, 4, 4)
    row, column = np.mgrid[:height, :width].reshape(2, -1) * finest
    squares = Squares(np.arange(width * height), row, column, corners)
    picture, parts, step = np.zeros((width * height, 3)), np.zeros(width * height, int), finest
    while True:
        divided = squares.differ(threshold) & (step > 1)
        whole = squares.some(~divided)
        colours = whole.corners[..., :3].mean(axis=1) * (step / finest) ** 2
        picture += np.stack([np.bincount(whole.pixel, channel, width * height) for channel in colours.T], axis=1)
        parts += np.bincount(whole.pixel, minlength=width * height)
        if not divided.any():
            break
        step //= 2
        squares = squares.some(divided).quartered(trace, step)
    return Antialiased(
        picture.reshape(height, width, 3).astype(scene.dtype), parts.reshape(height, width), trace.samples, trace.rays
    )


def compile_antialias(
    scene: Scene, camera: AbstractCamera, *, max_depth: int | None = None, cutoff: float | None = None
) -> None:
    """Compile the program of `antialias`, which is kept, without tracing a picture."""
    scene, camera, plan = _prepared(scene, camera, max_depth, cutoff)
    corner = np.zeros(1)
    tables = tables_of(scene, plan)
    _pass.lower(tables, camera, plan.program, packed_pass(plan, corner, corner, 1.0, scene.dtype)).compile()


def _prepared(
    scene: Scene, camera: AbstractCamera, max_depth: int | None, cutoff: float | None
) -> tuple[Scene, AbstractCamera, Plan]:
    """Scene and camera as they are traced, and the plan. The corners are a picture of one more row and column."""
    scene = scene.with_cutoff(cutoff)
    scene, camera = near(scene, camera)
    corners = camera.resized(camera.width + 1, camera.height + 1)
    return (
        scene,
        camera,
        make_plan(scene, corners, max_depth=depth_number(max_depth), capacity=likely_room(camera), footprint=0),
    )


def check_threshold(threshold) -> None:
    """Raise `SceneError` unless it is a difference of colours."""
    if (
        isinstance(threshold, bool)
        or not isinstance(threshold, (int, float, np.floating))
        or not 0 < threshold < np.inf
    ):
        raise SceneError(f"antialias = {threshold!r}; allowed is a difference of linear RGB > 0, such as 0.1")


class _Tracer:
    """Colours at places of the finest lattice; counts what it traces."""

    def __init__(self, scene: Scene, camera: AbstractCamera, plan: Plan, finest: int):
        self.program, self.plan, self.finest, self.dtype = (
            partial(_pass, tables_of(scene, plan), camera, plan.program),
            plan,
            finest,
            scene.dtype,
        )
        self.width = camera.width * finest + 1
        self.samples = self.rays = 0

    def __call__(self, row: np.ndarray, column: np.ndarray, step: int) -> np.ndarray:
        """Colour and doubt (n, 4) of rays that stand `step` apart."""
        film, rays = traced_list(
            self.program, self.plan, column / self.finest, row / self.finest, step / self.finest, self.dtype
        )
        self.samples, self.rays = self.samples + row.size, self.rays + rays
        return film.T

    def once(self, row: np.ndarray, column: np.ndarray, step: int) -> np.ndarray:
        """The same for places of which many are equal."""
        keys, where = np.unique(row.astype(np.int64) * self.width + column, return_inverse=True)
        return self(keys // self.width, keys % self.width, step)[where.reshape(row.shape)]


@dataclass(frozen=True, eq=False)
class Squares:
    """Parts of pixels, one entry each: their pixel, top left corner on the finest lattice, and (n, 4, 4) colours and
    doubt at the corners.
    """

    pixel: np.ndarray
    row: np.ndarray
    column: np.ndarray
    corners: np.ndarray
    """Top left, top right, bottom left, bottom right."""

    def some(self, chosen: np.ndarray) -> "Squares":
        return Squares(self.pixel[chosen], self.row[chosen], self.column[chosen], self.corners[chosen])

    def differ(self, threshold: float) -> np.ndarray:
        """Do the corners differ by more than the threshold, or may something small lie between them?"""
        a, b, c, d = (self.corners[:, k] for k in range(4))
        spread = np.maximum(np.maximum(a, b), np.maximum(c, d)) - np.minimum(np.minimum(a, b), np.minimum(c, d))
        return (spread[:, :3].max(axis=-1) > threshold) | (self.corners[..., 3].max(axis=-1) > 0)

    def quartered(self, trace: "_Tracer", half: int) -> "Squares":
        """Each divided into four: of their nine corners five are new, the middle and those of the sides."""
        down, across = np.asarray([(0, 1), (1, 0), (1, 1), (1, 2), (2, 1)]).T * half
        top, left, middle, right, bottom = trace.once(
            self.row[:, None] + down, self.column[:, None] + across, half
        ).transpose(1, 0, 2)
        a, b, c, d = (self.corners[:, k] for k in range(4))
        corners = [
            (a, top, left, middle),
            (top, b, middle, right),
            (left, middle, c, bottom),
            (middle, right, bottom, d),
        ]
        return Squares(
            np.tile(self.pixel, 4),
            np.concatenate([self.row + half * down for down in (0, 0, 1, 1)]),
            np.concatenate([self.column + half * right for right in (0, 1, 0, 1)]),
            np.concatenate([np.stack(four, axis=1) for four in corners]),
        )


@kept
def _pass(
    tables: Tables, camera: AbstractCamera, plan: Plan, samples: Samples
) -> tuple[Float[Array, "4 pixels"], Int[Array, ""]]:
    """One pass: colour, and how much light comes along rays that pass by something small; and the number of
    descendants.
    """
    light, beside, descendants = averaged(plan, samples, lambda s: trace_beside_small(tables, camera, plan, s))
    return jnp.concatenate([light.stacked(axis=0), beside.x[None]]), descendants
