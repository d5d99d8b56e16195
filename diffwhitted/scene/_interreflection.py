"""What radiosity asks for, and what may stand between two patches: by the search of the ray tree."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from .._errors import SceneError
from ..geometry import NOTHING, Departure, Ray, Shapes, blocked
from ..interreflection import MOST_PATCHES, SOLVERS, Patches, Places
from ..numerics._safe import safe_divide
from ..numerics._vector import dot, vec3
from ..records import nearest_name, whole_number
from ..shapes import OBJECTS, AbstractObject
from ._search import shapes_of

PATCHES, SOLVER = 500, "progressive"
BEFORE = 1e-4
"""What lies so near before the end of a ray, as a share of its length, is its end."""
RAYS = 1 << 18
"""So many are sent in one go."""


@dataclass(frozen=True)
class Interreflection:
    """What `radiosity` of a scene asks for: about so many patches, and the way to solve for their light."""

    patches: int = PATCHES
    solver: str = SOLVER

    @classmethod
    def read(cls, value, place: str = "scene: radiosity") -> "Interreflection | None":
        """From a table, or as it is."""
        return value if value is None or isinstance(value, cls) else cls.of(value, place)

    @classmethod
    def of(cls, value, place: str) -> "Interreflection":
        """From a table. Raises `SceneError` for a key, a number or a solver that is not allowed."""
        if not isinstance(value, Mapping):
            raise SceneError(f"{place} = {value!r}; allowed is a table such as {{ patches = {PATCHES} }}")
        keys = tuple(cls.__dataclass_fields__)
        for key in value:
            if key not in keys:
                raise SceneError(
                    f"{place}: unknown key {key!r}; allowed are {', '.join(keys)}.{nearest_name(key, keys)}"
                )
        patches = whole_number(value.get("patches", PATCHES), f"{place}: patches", 1, MOST_PATCHES)
        solver = value.get("solver", SOLVER)
        if solver not in SOLVERS:
            near = nearest_name(str(solver), SOLVERS)
            raise SceneError(f"{place}: solver = {solver!r}; allowed is {', '.join(SOLVERS)}.{near}")
        return cls(patches, solver)


class Obstacles(eqx.Module):
    """What may stand between two patches, or a patch and a lamp."""

    shapes: Shapes | None
    """None: nothing may."""
    surface_of: tuple[int, ...] = eqx.field(static=True)
    """The first surface there of each object of the scene; -1 for what cannot stand in any way."""

    def sees(self, patches: Patches):
        """Of places and points on charts: does light go from the one to the other? None: always."""
        if self.shapes is None:
            return None
        number, inwards = self.departures(patches)

        def sees(places: Places, targets: np.ndarray, chart: np.ndarray) -> np.ndarray:
            del chart
            return _in_batches(self.shapes, places.position, targets - places.position, number[places.chart],
                               inwards[places.chart], BEFORE)  # fmt: skip

        return sees

    def escapes(self, patches: Patches):
        """Of rays: do they meet nothing? Of all objects."""
        number, inwards = self.departures(patches)
        far = 4 * max(float(np.ptp(patches.loops.reshape(-1, 3), axis=0).max()), 1e-30)

        def escapes(places: Places) -> np.ndarray:
            return _in_batches(self.shapes, places.position, far * places.normal, number[places.chart],
                               inwards[places.chart], BEFORE)  # fmt: skip

        return escapes

    def departures(self, patches: Patches) -> tuple[np.ndarray, np.ndarray]:
        """The surface on which each chart lies, and whether rays leave its inner side."""
        faces = [(chart.face, chart.inner) for chart in patches.charts]
        first = (self.surface_of[face.object] for face, _ in faces)
        number = [NOTHING if one < 0 else one + face.surface for one, (face, _) in zip(first, faces, strict=True)]
        return np.asarray(number, np.int32), np.asarray([inner for _, inner in faces], bool)


def numbered(objects: Sequence[AbstractObject]) -> list[int]:
    """Their places in the order of the ray tree."""
    return [k for kind in OBJECTS for k, thing in enumerate(objects) if type(thing) is kind]


def obstacles_of(objects: Sequence[AbstractObject], patches: Patches) -> Obstacles:
    """The objects that may stand between two patches: not a plane one with everything on one side, nor the inside of a
    convex body.
    """
    order = numbered(objects)
    sides: dict[int, set[bool]] = {k: set() for k in order}
    faces: dict[int, set[tuple[int, int]]] = {k: set() for k in order}
    for chart in patches.charts:
        sides[chart.face.object].add(chart.inner)
        faces[chart.face.object].add((chart.face.surface, chart.face.slot))

    def stands(k: int) -> bool:
        thing = objects[k]
        if thing.solid:
            return not (thing.is_convex() and sides[k] == {True})
        return len(faces[k]) > 1 or len(sides[k]) > 1

    return _obstacles(objects, [k for k in order if stands(k)])


def opaque(objects: Sequence[AbstractObject]) -> Obstacles:
    """All objects."""
    return _obstacles(objects, numbered(objects))


def _obstacles(objects: Sequence[AbstractObject], there: list[int]) -> Obstacles:
    if not there:
        return Obstacles(None, (NOTHING,) * len(objects))
    counts = [objects[k].surfaces for k in there]
    first = dict(zip(there, (np.cumsum(counts) - counts).tolist(), strict=True))
    shapes = shapes_of([objects[k] for k in there], (), None)
    return Obstacles(shapes, tuple(first.get(k, NOTHING) for k in range(len(objects))))


def _in_batches(shapes: Any, start, way, number, inwards, before: float) -> np.ndarray:
    found = np.empty(len(start), bool)
    for first in range(0, len(start), RAYS):
        part = slice(first, first + RAYS)
        count = len(start[part])
        room = ((0, max(1 << max(count - 1, 0).bit_length(), 1024) - count), (0, 0))
        parts = (np.pad(a, room[: a.ndim], mode="edge") for a in (start[part], way[part], number[part], inwards[part]))
        with jax.ensure_compile_time_eval():
            free = _free(shapes, tuple(map(jnp.asarray, parts)), 1 - before)
        found[part] = np.asarray(free)[:count]
    return found


@eqx.filter_jit
def _free(shapes: Any, rays: tuple, limit: float):
    start, way, number, inwards = rays
    way = vec3(way)
    size = jnp.sqrt(dot(way, way))
    ray = Ray(vec3(start), way * safe_divide(1, size))
    return ~blocked(shapes, ray, Departure(number, inwards), size * limit, None)
