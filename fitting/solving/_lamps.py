"""Where lamps may stand, by the pictures: the start of a fit in which a direction or a place of a lamp is free.

Light and shadow tell of a lamp from within some thirty degrees; from further away a fit ends at a lamp that is wrong.
A picture says more than its slopes do. On a glossy object the highlight lies where the view, mirrored at the surface,
looks at the lamp; on a matte one light goes as the cosine between normal and lamp (Lambert), a linear equation a pixel.
These directions, and some all around, are tried: of each what is left over once all that the light is proportional to
has taken its best value. The best begins the fit where it leaves clearly less than the start does.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from diffwhitted import layers
from diffwhitted.records import changed
from diffwhitted.scene import Scene

from ..problem._problem import Problem, factorise
from ..problem._target import CheckedTarget
from ..problem._unknowns import Unknown, values_in
from ..problem._views import coarser

AROUND = 40
"""Directions, evenly spread: 32 degrees from one to the next."""
ENOUGH = 1500
"""So many pixels of a picture are enough to tell these apart."""
CLEARLY = 0.7
"""Of what the start leaves over; more is not clearly better."""
FEWEST = 12
"""Pixels of an object that is looked at."""
BRIGHT = 0.8
"""A highlight is what is brighter than this share of the way from the middle of the object's values to their largest.
"""
PROPORTIONAL = ("k_a", "k_d", "k_h", "k_s", "colour", "exposure", "black_level", "ambient")
"""What the light of a picture is proportional to, one at a time."""


@dataclass(frozen=True)
class Lamp:
    """A lamp of which direction or place is free: its number in the scene, the key, and the numbers of its unknowns."""

    number: int
    key: str
    unknowns: tuple[int, ...]


def best_lamps(
    scene: Scene, targets: Sequence[CheckedTarget], problem: Problem, start: np.ndarray
) -> tuple[np.ndarray, tuple[str, ...]]:
    """The start, or a better one for the lamps, and the names of what was moved."""
    if problem.ties is not None or not (lamps := _free_lamps(scene, problem.unknowns)):
        return start, ()
    values, moved = start, []
    views = tuple(coarser(view, _step(view.weight[..., 0].size)) for view in problem.views)
    looks = [_Look.of(scene, target) for target in targets]
    for lamp in lamps:
        name = scene.lights[lamp.number].name
        mine = [k for k, t in enumerate(targets) if t.shot.burns(name)]
        part = replace(problem, views=tuple(views[k] for k in mine))
        best, least = values, CLEARLY * _left(part, values, lamp)
        for candidate in _candidates(scene, lamp, [looks[k] for k in mine], values, problem.unknowns):
            if (left := _left(part, candidate, lamp)) < least:
                best, least = candidate, left
        if best is not values:
            values = best
            moved.append(f"light.{name}.{lamp.key}")
    return values, tuple(moved)


def _free_lamps(scene: Scene, unknowns: Sequence[Unknown]) -> list[Lamp]:
    """The lamps at infinity whose direction is free, and the others whose place is, with all numbers of it."""
    found = []
    for number, light in enumerate(scene.lights):
        key = "direction" if light.place() is None else "position"
        mine = tuple(
            i
            for i, u in enumerate(unknowns)
            if u.parameter.family == "light" and u.parameter.owner == light.name and u.row.name == key
        )
        if len(mine) == (2 if key == "direction" else 3):
            found.append(Lamp(number, key, mine))
    return found


def _step(pixels: int) -> int:
    """The largest power of 2 of whose squares there are enough."""
    step = 1
    while pixels >= 4 * step**2 * ENOUGH:
        step *= 2
    return step


def _left(problem: Problem, values: np.ndarray, lamp: Lamp) -> float:
    """Sum of squares that is left with this lamp, when all that light is proportional to is as good as can be."""
    factor, _ = factorise(problem, values)
    free = [
        i
        for i, u in enumerate(problem.unknowns)
        if i not in lamp.unknowns and u.row.name in PROPORTIONAL and np.any(factor[:, i])
    ]
    rows, right = factor[:, free], factor[:, -1]
    low, high = (np.asarray([u.bounds[k] for u in problem.unknowns])[free] - values[free] for k in (0, 1))
    step = np.clip(np.linalg.lstsq(rows, -right, rcond=1e-6)[0], low, high) if free else np.zeros(0)
    return min(float(np.sum((right + rows @ step) ** 2)), float(right @ right))


def _candidates(
    scene: Scene, lamp: Lamp, looks: "Sequence[_Look]", values: np.ndarray, unknowns
) -> Iterator[np.ndarray]:
    """The values with the lamp elsewhere, within its bounds: where pictures point to, then all around."""
    pointed = [pair for look in looks for pair in look.towards()]
    middle = np.mean([look.middle for look in looks], axis=0)
    light = scene.lights[lamp.number]
    for point, way in [*pointed, *((middle, way) for way in _all_around())]:
        if lamp.key == "direction":
            new = way * float(np.linalg.norm(np.asarray(getattr(light, lamp.key), np.float64)))
        else:
            new = point + way * float(np.linalg.norm(np.asarray(light.place(), np.float64) - middle))
        lights = list(scene.lights)
        lights[lamp.number] = changed(light, **{lamp.key: jnp.asarray(new, scene.dtype)})
        there = values_in(scene, unknowns, changed(scene, lights=tuple(lights)))
        chosen = np.asarray(lamp.unknowns)
        low, high = np.asarray([unknowns[i].bounds for i in chosen]).T
        if np.all((low < there[chosen]) & (there[chosen] < high)):
            candidate = values.copy()
            candidate[chosen] = there[chosen]
            yield candidate


def _all_around() -> Float[np.ndarray, "n 3"]:
    """Directions on a spiral around the sphere, each for the same area."""
    number = np.arange(AROUND) + 0.5
    height, turn = 1 - 2 * number / AROUND, np.pi * (1 + 5**0.5) * number
    flat = np.sqrt(1 - height**2)
    return np.stack([flat * np.cos(turn), height, flat * np.sin(turn)], axis=1)


@dataclass(frozen=True)
class _Look:
    """What a target shows of each object that its camera sees."""

    value: Float[np.ndarray, "n"]
    """Mean of the channels."""
    normal: Float[np.ndarray, "n 3"]
    view: Float[np.ndarray, "n 3"]
    """From the camera."""
    point: Float[np.ndarray, "n 3"]
    object: np.ndarray

    @staticmethod
    def of(scene: Scene, target: CheckedTarget) -> "_Look":
        camera = scene.cameras[target.camera]
        seen = layers(scene, camera)
        used = (seen.object >= 0) & (target.mask > 0)
        row, column = np.nonzero(used)
        ray = camera.rays(jnp.asarray(column + 0.5, scene.dtype), jnp.asarray(row + 0.5, scene.dtype))
        view = np.asarray(ray.direction.stacked(axis=1), np.float64)
        point = np.asarray(ray.origin.stacked(axis=1), np.float64) + view * seen.depth[used][:, None]
        return _Look(target.image[used].mean(axis=1), seen.normal[used], view, point, seen.object[used])

    @property
    def middle(self) -> np.ndarray:
        return self.point.mean(axis=0) if len(self.point) else np.zeros(3)

    def towards(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Points, and unit directions in which a lamp may be seen from there."""
        for number in np.unique(self.object):
            mine = self.object == number
            if mine.sum() < FEWEST:
                continue
            value, normal, view, point = (a[mine] for a in (self.value, self.normal, self.view, self.point))
            low = np.median(value)
            shares = np.maximum(value - low - BRIGHT * (value.max() - low), 0)
            if shares.any():
                mirrored = view - 2 * np.sum(view * normal, axis=1, keepdims=True) * normal
                yield shares @ point / shares.sum(), _unit(shares @ mirrored)
            lit = value > low
            shading = np.linalg.lstsq(np.column_stack([normal[lit], np.ones(lit.sum())]), value[lit], rcond=1e-4)[0]
            if np.any(shading[:3]):
                yield point.mean(axis=0), _unit(shading[:3])


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / max(float(np.linalg.norm(vector)), 1e-12)
