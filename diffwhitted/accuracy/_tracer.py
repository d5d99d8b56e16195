"""One scene from one camera with any settings, from programs that are compiled once and then kept.

The samples of a pixel, the depth and the cutoff are values here, not parts of a program as they are in `render`; the
work is the same, and so are picture and time.
"""

import time
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np

from .._errors import CapacityError
from ..numerics._kept import kept
from ..numerics._workers import processors, side_by_side
from ..rendering._antialias import antialias, compile_antialias
from ..rendering._radiance_bound import most_beyond
from ..scene import DEEPEST, AbstractCamera, Scene, Tables, near
from ..tree import (
    Beyond,
    Plan,
    Samples,
    averaged,
    likely_room,
    make_plan,
    tables_of,
    trace,
    trace_left_out,
    trees_or_points,
)
from ._blur import with_blur_samples
from ._knobs import Settings
from ._places import MOST_PLACES, Corners, Places, dealt, middles, place_groups

FEWEST_PIXELS = 2048
"""Twice so many, or more, are dealt to all processors."""


@dataclass(frozen=True, eq=False)
class Traced:
    """What some pixels look like with some settings, and what that took."""

    settings: Settings
    pixels: np.ndarray
    """(n, 3), linear Rec. 709 RGB, float64."""
    rays: int
    seconds: float


class Tracer:
    """`scene` seen by `camera`, some or all of its pixels at a time.

    - `pass_of`: so many pixels are traced in one go; without it, a pass is that of `render`.

    Raises `CapacityError` where the tree of one ray outgrows the room.
    """

    def __init__(self, scene: Scene, camera: AbstractCamera, pass_of: int | None = None):
        self.scene, self.camera = near(scene, camera)
        side = None if pass_of is None else int(np.ceil(pass_of**0.5))
        self._sized = self.camera if side is None else self.camera.resized(side, side)
        self._plans: dict[tuple, Plan] = {}
        self._compiled: set[tuple | Settings] = set()
        self._crowded: dict[Settings, float] = {}
        self.seconds_compile = 0.0
        """So far, for all programs."""

    @property
    def branches(self) -> bool:
        """Are there reflected or refracted rays?"""
        return self.plan(Settings()).effects.branching

    @property
    def all_pixels(self) -> np.ndarray:
        """The numbers of the pixels, row by row."""
        return np.arange(self.camera.width * self.camera.height)

    def scene_with(self, settings: Settings) -> Scene:
        """The scene with its lamps looked at, and its meshes and materials shaded, as these settings say."""
        return settings.applied(self.scene)

    def camera_with(self, settings: Settings) -> AbstractCamera:
        """The camera with as many places in its lens as these settings say."""
        return with_blur_samples(self.camera, settings.blur_samples)

    def trace(self, settings: Settings, pixels: np.ndarray | None = None) -> Traced:
        """Trace these pixels, all by default, as `render` does; a program that is not there yet is compiled first."""
        if settings.antialias:
            return self._antialiased(settings, pixels)
        settings = self._able(settings)
        pixels, side = self.all_pixels if pixels is None else pixels, settings.footprint or settings.samples
        films, rays, seconds = self._films(settings, *self._corners(pixels), place_groups(side, self.scene.dtype))
        return Traced(settings, films / side**2, rays + len(pixels) * side**2, seconds)

    def left_out(self, settings: Settings, pixels: np.ndarray | None = None) -> np.ndarray | None:
        """The bound of `render_with_bound` for the picture of these settings, (n, 3): how much brighter each of these
        pixels could be if depth and cutoff ended no branch of its trees. It says nothing of what lies between the
        samples.

        None with antialiasing, where what was traced decides what is traced next.
        """
        if settings.antialias:
            return None
        settings = self._able(settings)
        pixels, side = self.all_pixels if pixels is None else pixels, settings.footprint or settings.samples
        if not self.branches:
            return np.zeros((len(pixels), 3))
        beyond = most_beyond(self.scene, self.camera, self.plan(settings))
        films, _, _ = self._films(settings, *self._corners(pixels), place_groups(side, self.scene.dtype), beyond)
        return films / side**2

    def _able(self, settings: Settings) -> Settings:
        """The same with points in place of filtered trees where something in the scene knows points only."""
        footprint, points = trees_or_points(self.scene, settings.footprint)
        return settings if footprint == settings.footprint else replace(settings, footprint=0, samples=points)

    def _corners(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Column and row of pixels."""
        row, column = np.divmod(pixels, self.camera.width)
        return column.astype(self.scene.dtype), row.astype(self.scene.dtype)

    def trace_spread(self, settings: Settings, pixels: np.ndarray) -> Traced:
        """The same, with all trees of a few pixels side by side: full passes also where the pixels are few and their
        trees many.
        """
        settings = self._able(settings)
        side = settings.footprint or settings.samples
        column, row = (np.repeat(at, side**2) for at in (pixels % self.camera.width, pixels // self.camera.width))
        inside = np.tile(middles(side).T - 0.5 / side, len(pixels))
        column, row = ((at + more).astype(self.scene.dtype) for at, more in zip((column, row), inside, strict=True))
        middle = jnp.zeros((MOST_PLACES, 2), self.scene.dtype) + 0.5 / side, jnp.int32(1), jnp.int32(0)
        place = np.tile(np.arange(side**2, dtype=np.int32), len(pixels))
        films, rays, seconds = self._films(settings, column, row, [middle], place=place)
        return Traced(settings, films.reshape(len(pixels), side**2, 3).mean(axis=1), rays + len(column), seconds)

    def _antialiased(self, settings: Settings, pixels: np.ndarray | None) -> Traced:
        """Pixels share their corners, so the whole picture is traced, and some of it costs its part."""

        program = replace(settings, antialias=1.0, cutoff=float(settings.cutoff > 0) / 2)
        options = {"max_depth": settings.depth, "cutoff": settings.cutoff}
        if program not in self._compiled:
            begun = time.perf_counter()
            compile_antialias(self.scene_with(settings), self.camera_with(settings), **options)
            self.seconds_compile += time.perf_counter() - begun
            self._compiled.add(program)
        begun = time.perf_counter()
        found = antialias(self.scene_with(settings), self.camera_with(settings), settings.antialias, **options)
        seconds = time.perf_counter() - begun
        picture = found.image.reshape(-1, 3).astype(np.float64)
        if pixels is None:
            return Traced(settings, picture, found.rays, seconds)
        part = len(pixels) / len(picture)
        return Traced(settings, picture[pixels], round(part * found.rays), part * seconds)

    def _films(
        self,
        settings: Settings,
        column: np.ndarray,
        row: np.ndarray,
        groups: list[Places],
        beyond: Beyond | None = None,
        place: np.ndarray | None = None,
    ) -> tuple[np.ndarray, int, float]:
        """The sum over places at each corner (n, 3), the rays other than camera rays, and the seconds; with `beyond`,
        of what is left out.
        """
        plan, scene = self.compiled(settings, beyond), self.scene_with(settings).with_cutoff(settings.cutoff)
        tables, camera = tables_of(scene, plan), self.camera_with(settings)
        how = jnp.asarray(settings.depth, jnp.int32), jnp.asarray(1 / max(settings.footprint, 1), scene.dtype), beyond

        def film_of(corners):
            return [_pass(tables, camera, plan.program, corners, *places, *how) for places in groups]

        fewest = max(-(-len(column) // plan.pass_pixels), min(processors(), len(column) // FEWEST_PIXELS), 1)
        count = min(max(fewest, int(fewest * self._crowded.get(settings, 1))), len(column))
        while True:
            passes = dealt(plan, column, row, count, place)
            begun = time.perf_counter()
            films = side_by_side(film_of, passes)
            seconds = time.perf_counter() - begun
            if max(int(most) for film in films for _, most, _ in film) <= plan.capacity:
                break
            if count >= len(column):
                raise CapacityError(
                    f"the tree of one ray needs more room than {plan.capacity} rays; lower the depth or raise the "
                    "cutoff"
                )
            count = min(2 * count, len(column))
        self._crowded[settings] = count / fewest
        total = np.stack([sum(np.asarray(part, np.float64) for part, _, _ in film) for film in films])
        return (
            total.transpose(2, 0, 1).reshape(-1, 3)[: len(column)],
            sum(int(more) for film in films for _, _, more in film),
            seconds,
        )

    def compiled(self, settings: Settings, beyond: Beyond | None = None) -> Plan:
        """The plan that serves these settings, its program compiled. What is left out does not hang on shadows."""
        plan = self.plan(settings)
        if beyond is not None:
            plan = replace(plan, effects=plan.effects.switched(shadows=False, tinted_shadows=False))
        if (program := (plan, beyond is None, *settings.variant)) not in self._compiled:
            begun = time.perf_counter()
            nobody = dealt(plan, corner := np.zeros(1, self.scene.dtype), corner, 1)[0]
            places = place_groups(1, self.scene.dtype)[0]
            _pass.lower(
                tables_of(self.scene_with(settings), plan),
                self.camera_with(settings),
                plan.program,
                nobody,
                *places,
                jnp.int32(1),
                jnp.asarray(1, self.scene.dtype),
                beyond,
            ).compile()
            self.seconds_compile += time.perf_counter() - begun
            self._compiled.add(program)
        return plan

    def plan(self, settings: Settings) -> Plan:
        """One plan for points and one for footprints, as deep as settings may be, with a cutoff where anything
        branches.
        """
        kind = bool(settings.footprint), *settings.variant
        if kind not in self._plans:
            scene, room = self.scene_with(settings), likely_room(self._sized)
            camera = with_blur_samples(self._sized, settings.blur_samples)
            plan = make_plan(scene, camera, max_depth=DEEPEST, capacity=room, footprint=int(kind[0]))
            branching = plan.effects.reflection or plan.effects.refraction
            self._plans[kind] = replace(plan, effects=plan.effects.switched(cutoff=branching))
        return self._plans[kind]


@kept
def _pass(
    tables: Tables,
    camera: AbstractCamera,
    plan: Plan,
    corners: Corners,
    places,
    count,
    first,
    depth,
    side,
    beyond: Beyond | None = None,
):
    """The sum of the films of `count` places (3, pixels); of their descendants, the largest number and the sum.

    With `beyond` the film is of the most light that the branches that are not followed could bring.
    """
    tables = replace(tables, max_depth=depth)

    def one_place(number, state):
        film, most, total = state
        column, row = corners.column + places[number, 0], corners.row + places[number, 1]
        samples = Samples(column, row, corners.there, side, jnp.int32(0), corners.place + first + number)

        def one(samples):
            if beyond is not None:
                return trace_left_out(tables, camera, plan, samples, beyond)
            light, _, descendants = trace(tables, camera, plan, samples)
            return light, descendants

        light, descendants = averaged(plan, samples, one)
        return film + light.stacked(axis=0), jnp.maximum(most, descendants), total + descendants

    nothing = jnp.zeros((3, plan.pass_pixels), camera.look_from.dtype), jnp.int32(0), jnp.int32(0)
    return jax.lax.fori_loop(0, count, one_place, nothing)
