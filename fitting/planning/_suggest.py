"""Where one more lamp, or one more camera, would tell most of what is free."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from diffwhitted.records import changed
from diffwhitted.scene import PointLight, Scene

from .._errors import FitError
from ..judging._identifiability import Uncertainty
from ._additions import Movable, movable, surroundings
from ._identification import Identification
from ._identify import Question, identification, question
from ._looking import Pictures, together
from ._snippet import scene_tables
from ._sphere import all_around, best_direction

DIRECTIONS = 40
DIGITS = 3
"""Of the place, relative to its distance: what a person can put up."""
UPRIGHT = 0.98
"""A camera that looks straight up or down (this cosine) has no up."""


@dataclass(frozen=True, eq=False)
class Suggestion:
    """Where to put a lamp or a camera.

    - `what`: "light" or "camera"; `name`: by which it is in `scene`; `added`: it is one more.
    - `place`: (x, y, z) in metres; of a directional light the direction towards it.
    - `before`, `after`: what a fit would know without it (or where it stands now), and with it there.
    - `scene`: with it; `toml`: its table, and that of its shot, for a scene file; `tried`: how many places.
    """

    what: str
    name: str
    added: bool
    place: tuple[float, float, float]
    before: Identification
    after: Identification
    scene: Scene = field(repr=False)
    toml: str
    tried: int

    @property
    def gain(self) -> float:
        """The standard errors are so many times smaller: the geometric mean over what is determined before and after;
        NaN where that is nothing."""
        pairs = zip(self.before.coefficients, self.after.coefficients, strict=True)
        logs = [np.log(b.standard_error / a.standard_error) for b, a in pairs if b.standard_error and a.standard_error]
        return float(np.exp(np.mean(logs))) if logs else float("nan")

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "what": self.what,
            "name": self.name,
            "added": self.added,
            "place": list(self.place),
            "gain": self.gain if np.isfinite(self.gain) else None,
            "tried": self.tried,
            "toml": self.toml,
            "before": self.before.to_json(),
            "after": self.after.to_json(),
        }


def suggest(
    scene: Scene,
    free: Sequence[str],
    what: str = "light",
    *,
    noise=None,
    cameras: str | Sequence[str] | None = None,
    only: str | Sequence[str] = (),
    bounds: Mapping[str, tuple[float, float]] | None = None,
    samples: int = 1,
    max_depth: int | None = None,
    footprint: int | None = None,
    directions: int = DIRECTIONS,
    at_try: Callable[[int], None] = lambda number: None,
) -> Suggestion:
    """The place of a lamp or a camera that lowers the standard errors most.

    - `what`: "light" or "camera" for one more, like the first of the scene; "light.NAME" or "camera.NAME" for one that
      is there. One more lamp burns with the others in all pictures; in a scene with shots it, or one more camera, has a
      shot of its own (the lamp: it alone, by the camera of the first shot).
    - `directions`: how many are tried, evenly around the middle of what is seen of the objects asked about, at the
      distance of the scene's lamps or cameras; from the best of them a search goes on. `at_try` is told the number of
      each try.
    - All else as in `identify`.

    Best is the place with the highest rank and, of these, the least sum of the logarithms of the standard errors.
    Places inside of objects are left out; a camera looks at the middle. Raises `FitError` as `identify`, for a scene
    far from the origin, and for what cannot be put elsewhere.
    """
    if scene.keeps_digits:
        raise FitError(
            "suggest: the scene is far from the origin of its coordinates; move it near to the origin, or use float64"
        )
    asked = question(scene, free, noise, cameras, only, bounds, samples, max_depth, footprint)
    thing = movable(asked.scene, asked.targets, what, asked.unknowns, bool(scene.shots))
    factor, shown = asked.about(asked.scene, asked.targets).factor()
    before = identification(asked, shown, asked.known(factor))
    trial = _Trial.of(asked, thing)
    tried = []
    direction = best_direction(
        trial.score, trial.possible(all_around(directions)), lambda n: (tried.append(n), at_try(n))[1]
    )
    place = trial.place_of(direction, rounded=True)
    found, seen = trial.whole(place)
    after = replace(asked, targets=(*thing.others, *thing.changed))
    return Suggestion(
        thing.family,
        thing.name,
        thing.added,
        (float(place[0]), float(place[1]), float(place[2])),
        before,
        identification(after, seen, found),
        changed(thing.at(place, trial.middle), shots=_shots(scene, thing)),
        _toml(thing, trial.middle, place, bool(scene.shots)),
        len(tried),
    )


@dataclass(frozen=True)
class _Trial:
    """Places tried: what is known with the thing there."""

    asked: Question
    thing: Movable
    middle: np.ndarray
    distance: float
    base: np.ndarray
    """The factor of the pictures that do not change, (p, p)."""
    shown: tuple
    """What they show."""
    pictures: Pictures
    """Those that do."""

    @staticmethod
    def of(asked: Question, thing: Movable) -> _Trial:
        cameras = [asked.scene.cameras[name] for name in dict.fromkeys(t.camera for t in asked.targets)]
        middle = surroundings(asked.scene, cameras, asked.unknowns)
        base, shown = np.zeros((len(asked.unknowns),) * 2), ()
        if thing.others:
            base, shown = asked.about(thing.scene, thing.others).factor()
        pictures = asked.about(thing.scene, thing.changed)
        distance = _distance(asked.scene, thing, middle, cameras)
        return _Trial(asked, thing, _rounded(middle, distance), distance, base, shown, pictures)

    def place_of(self, direction: np.ndarray, rounded: bool = False) -> np.ndarray:
        place = direction if self.thing.far else self.middle + self.distance * direction
        return _rounded(place, 1.0 if self.thing.far else self.distance) if rounded else place

    def possible(self, directions: np.ndarray) -> np.ndarray:
        """Those that are not inside of an object. Raises `FitError` where none is left."""
        free = [d for d in directions if self._stands_free(d)]
        if not free:
            raise FitError(
                "suggest: every place that was looked at is inside of an object; move the lamps or cameras out"
            )
        return np.stack(free)

    def _stands_free(self, direction: np.ndarray) -> bool:
        up = self.thing.up
        if up is not None and abs(direction @ up) > UPRIGHT * np.linalg.norm(up):
            return False
        place = self.place_of(direction)
        return self.thing.far or not any(thing.holds(place) for thing in self.asked.scene.placed_objects())

    def score(self, direction: np.ndarray) -> tuple[int, float]:
        """Rank, and minus the sum of the logarithms of the standard errors in each one's own scale."""
        if not self._stands_free(direction):
            return -1, 0.0
        factor = self._there(self.place_of(direction), few=True).glance()
        known = self.asked.known(together(self.base, factor))
        scale = [u.row.measured_in.slope(v) for u, v in zip(self.asked.unknowns, self.asked.values, strict=True)]
        error = known.spread * np.asarray(scale)
        return known.rank, -float(np.log(error[error > 0]).sum())

    def whole(self, place: np.ndarray) -> tuple[Uncertainty, tuple]:
        """What all pixels say with it there, and what the pictures show."""
        factor, shown = self._there(place).factor()
        return self.asked.known(together(self.base, factor)), (*self.shown, *shown)

    def _there(self, place: np.ndarray, few: bool = False) -> Pictures:
        scene = self.thing.at(place, self.middle, self.pictures.problem.scene)
        return self.pictures.retraced(scene, few)


def _rounded(place: np.ndarray, size: float) -> np.ndarray:
    """To so many digits of the size; no negative zero."""
    return np.round(place, DIGITS - int(np.floor(np.log10(size))) - 1) + 0.0


def _distance(scene: Scene, thing: Movable, middle: np.ndarray, cameras) -> float:
    """That of the lamps, or cameras, of the scene from the middle: the median; of one that is there, its own."""
    places = [np.asarray(camera.look_from, np.float64) for camera in cameras]
    if thing.family == "light":
        lamps = [np.asarray(light.position, np.float64) for light in scene.lights if isinstance(light, PointLight)]
        places = lamps or places
    if not thing.added and thing.place is not None:
        places = [thing.place]
    return float(max(np.median([np.linalg.norm(place - middle) for place in places]), 1e-6))


def _shots(scene: Scene, thing: Movable) -> tuple:
    """The shots of the scene with the thing: those of a scene that has some."""
    return tuple(t.shot for t in (*thing.others, *thing.changed)) if scene.shots else ()


def _toml(thing: Movable, middle: np.ndarray, place: np.ndarray, taken: bool) -> str:
    """The table of the lamp or camera and, where pictures are taken by shots, that of its shot."""
    scene = thing.at(place, middle)
    wanted = {(thing.family, thing.name)}
    if taken and thing.added:
        scene, wanted = changed(scene, shots=tuple(t.shot for t in thing.changed)), wanted | {("shot", thing.name)}
    return scene_tables(scene, wanted)
