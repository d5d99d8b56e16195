"""The unknowns of a fit: one number each, with bounds and a start, and from their values back into the scene."""

import fnmatch
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from jaxtyping import Array, Float

from diffwhitted.records import Row, typical_size
from diffwhitted.scene import Parameter, Scene, nearest_name
from diffwhitted.tree import calls_for

from .._errors import FitError
from ._free_names import split_free, whole_names
from ._freedoms import moved, parts_of, read
from ._ranges import checked_bounds, default_bounds


@dataclass(frozen=True)
class Unknown:
    """One number that a fit looks for: a parameter, one number of it, or an angle by which it turns."""

    parameter: Parameter
    part: int
    """Its place among the unknowns of the parameter (see `_freedoms`)."""
    component: str
    """Its name after that of the parameter, such as "r"; empty for one number."""
    unit: str
    counted: bool
    """Counted from the scene that the fit was given: an angle, or a move within a plane."""
    bounds: tuple[float, float]
    prior: tuple[float, float] | None = None
    """Mean and standard deviation of what was known of it before."""
    sums: tuple[tuple[tuple[str, ...], float], ...] = ()
    """The sums that it is in: the names of all that are added, and the most that they may come to."""

    @property
    def name(self) -> str:
        """ "glass.k_d", "floor.k_d.r" for a channel, "light.sun.direction.u" for an angle."""
        return f"{self.parameter.name}.{self.component}" if self.component else self.parameter.name

    @property
    def row(self) -> Row:
        """That of its parameter: interval, scale, what it moves. What is counted from the scene is linear and has no
        interval.
        """
        return (
            replace(self.parameter.row, scale="unbounded", lowest=-inf, highest=inf)
            if self.counted
            else self.parameter.row
        )

    @property
    def moves(self) -> bool:
        """Does a change of it move edges in the picture, so that rays are recorded anew?"""
        return self.row.moves != "nothing"

    def size(self, value: float) -> float:
        """What a step of it is small against."""
        return typical_size(value, self.row.lowest, *self.bounds)


def list_unknowns(
    scene: Scene, names: Sequence[str], bounds: Mapping[str, tuple[float, float]] | None = None
) -> tuple[Unknown, ...]:
    """The unknowns of these names: of a parameter all its numbers, three where it is linear RGB in the scene; of a
    component that alone. `bounds` may use wildcards."""
    unknowns = []
    for name in names:
        parameter, component = split_free(scene, name)
        parameter = _as_it_moves(scene, parameter, names)
        values = read(scene, parameter, scene)
        for number, part in enumerate(parts_of(scene, parameter)):
            if component in ("", part.component):
                ends = default_bounds(scene, parameter, float(values[number]), part.counted, part.unit)
                unknowns.append(Unknown(parameter, number, part.component, part.unit, part.counted, ends))
    for pattern, ends in (bounds or {}).items():
        for i in matching(unknowns, pattern, "bounds"):
            unknowns[i] = replace(unknowns[i], bounds=_checked_bounds(unknowns[i], ends))
    return tuple(unknowns)


def _as_it_moves(scene: Scene, parameter: Parameter, free: Sequence[str]) -> Parameter:
    """The same, but for the index of what lets no light through: it weighs the mirror ray, and moves none."""
    still = parameter.family == "material" and parameter.row.moves == "rays"
    if still and calls_for(scene, parameter.owner, "k_t", whole_names(scene, free)) is None:
        return replace(parameter, row=replace(parameter.row, moves="nothing"))
    return parameter


def start_values(
    scene: Scene, unknowns: tuple[Unknown, ...], start: Mapping[str, float | Sequence[float]] | None = None
) -> np.ndarray:
    """Where the fit begins: the scene's values, replaced by those in `start` (names, with wildcards).

    Raises `FitError` for a start outside the bounds and for a name that is not free.
    """
    values = values_in(scene, unknowns, scene)
    for pattern, value in (start or {}).items():
        for i in matching(unknowns, pattern, "start"):
            values[i] = _start_number(scene, unknowns[i], pattern, value)
    for u, value in zip(unknowns, values, strict=True):
        low, high = u.bounds
        slack = 1e-6 * (high - low)
        at_the_end_of_a_log = u.row.measured_in.open and value == u.row.lowest
        if not low - slack <= value <= high + slack and not at_the_end_of_a_log:
            raise FitError(
                f"start: {u.name} = {value:g} is outside its bounds {low:g} to {high:g}; start inside, or widen them "
                f"with bounds={{{u.name!r}: (low, high)}} (diffwhitted fit --bounds {u.name}=LOW:HIGH)"
            )
    return np.clip(values, *np.asarray([u.bounds for u in unknowns]).T)


def sums_of(unknowns: Sequence[Unknown]) -> tuple[tuple[tuple[int, ...], float], ...]:
    """All sums that have a limit: the numbers of the unknowns that are added, and the limit."""
    numbers = {u.name: i for i, u in enumerate(unknowns)}
    sums = dict.fromkeys(entry for u in unknowns for entry in u.sums)
    return tuple((tuple(numbers[name] for name in names), limit) for names, limit in sums)


def values_in(scene: Scene, unknowns: Sequence[Unknown], other: Scene) -> np.ndarray:
    """The unknowns in another scene, float64; what is counted, counted from `scene`."""
    held = {u.parameter: read(scene, u.parameter, other) for u in unknowns}
    return np.asarray([held[u.parameter][u.part] for u in unknowns], np.float64)


def insert(scene: Scene, unknowns: tuple[Unknown, ...], values: Float[Array | np.ndarray, "p"]) -> Scene:
    """The scene with the values of the unknowns; differentiable."""
    new = scene
    for parameter in dict.fromkeys(u.parameter for u in unknowns):
        mine = [i for i, u in enumerate(unknowns) if u.parameter == parameter]
        numbers = [unknowns[i].part for i in mine]
        new = parameter.replaced(new, moved(scene, new, parameter, numbers, values[np.asarray(mine)]))
    return new


def free_as_named(scene: Scene, unknowns: Sequence[Unknown]) -> tuple[str, ...]:
    """What is free, as `free_parameters` has it: a parameter of which everything is free by its own name."""
    count: dict[Parameter, int] = {}
    for u in unknowns:
        count[u.parameter] = count.get(u.parameter, 0) + 1
    whole = {parameter for parameter, number in count.items() if number == len(parts_of(scene, parameter))}
    return tuple(dict.fromkeys(u.parameter.name if u.parameter in whole else u.name for u in unknowns))


def matching(unknowns: Sequence[Unknown], pattern: str, option: str) -> list[int]:
    """The numbers of the unknowns of that very name or, where there is none, of those that match it as a pattern.

    As with free names, a pattern means materials unless it begins with a family word. Raises `FitError` where there is
    none; `option` is what gave the pattern.
    """
    names = [_names_of(u) for u in unknowns]
    exact = [i for i, known in enumerate(names) if pattern in known]
    if exact:
        return exact
    family = pattern.partition(".")[0]
    found = [
        i
        for i, (u, known) in enumerate(zip(unknowns, names, strict=True))
        if u.parameter.family in ("material", family) and any(fnmatch.fnmatchcase(name, pattern) for name in known)
    ]
    if not found:
        free = list(dict.fromkeys(u.name for u in unknowns))
        near = nearest_name(pattern, [*free, *(u.parameter.name for u in unknowns)])
        raise FitError(f"{option}: {pattern!r} matches no free coefficient; free are {', '.join(free)}.{near}")
    return found


def _names_of(unknown: Unknown) -> tuple[str, ...]:
    """All names that an unknown goes by: its own, that of its parameter, and with the word "material" before them."""
    names = unknown.name, unknown.parameter.name
    return (*names, *(f"material.{name}" for name in names)) if unknown.parameter.family == "material" else names


def _start_number(scene: Scene, unknown: Unknown, pattern: str, value) -> float:
    """Its own of the numbers that are given for its parameter, or the one number."""
    given = np.ravel(np.asarray(value, object)).tolist()
    parts = len(parts_of(scene, unknown.parameter))
    if not are_numbers(given) or np.ndim(value) > 1 or len(given) not in (1, parts) or np.size(value) != len(given):
        grey = f"; write {unknown.name} as three numbers in the scene, or name it with colour (--colour)" * (
            unknown.row.coloured and parts == 1 and len(given) == 3
        )
        several = f", or {parts} numbers, one for each component" if parts > 1 else ""
        raise FitError(f"start: {pattern} = {value!r}; allowed is a number{several} of {unknown.parameter.name}{grey}")
    return float(given[unknown.part if len(given) > 1 else 0])


def are_numbers(values) -> bool:
    try:
        return all(np.isfinite(float(value)) and not isinstance(value, str) for value in values)
    except (TypeError, ValueError):
        return False


def _checked_bounds(unknown: Unknown, ends) -> tuple[float, float]:
    if np.shape(ends) != (2,) or not are_numbers(ends):
        raise FitError(f"bounds: {unknown.name} = {ends!r}; allowed is (low, high), two finite numbers")
    low, high = map(float, ends)
    if low == high:
        raise FitError(
            f"bounds: {unknown.name} = {low:g} to {high:g} leaves nothing to look for; leave it out of free (--free) "
            f"and write {low:g} in the scene"
        )
    if allowed := checked_bounds(unknown.row, unknown.counted, (low, high)):
        raise FitError(f"bounds: {unknown.name} = {low:g} to {high:g}; allowed is {allowed}")
    return low, high
