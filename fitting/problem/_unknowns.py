"""From free names such as "*.k_d" to the unknowns of a fit, and from unknowns back into the scene."""

import fnmatch
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from diffwhitted.scene import BY_NAME, COEFFICIENTS, Row, Scene, coefficient_value, nearest_name, replace_coefficient

from .._errors import FitError

CHANNELS = ("r", "g", "b")


@dataclass(frozen=True)
class Unknown:
    """One number that a fit looks for: a coefficient, or one channel of a coloured one."""

    coefficient: str
    """As in `replace_coefficient`: "glass.k_d"."""
    channel: int | None
    row: Row
    bounds: tuple[float, float]

    @property
    def name(self) -> str:
        """ "glass.k_d", or "floor.k_d.r" for a channel."""
        return self.coefficient if self.channel is None else f"{self.coefficient}.{CHANNELS[self.channel]}"


def free_coefficients(
    scene: Scene, patterns: Sequence[str], max_depth: int | None = None
) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
    """The coefficients that the patterns name, in the order of the scene, and those passed over with the reason.

    A pattern with a wildcard passes over coefficients that cannot change the image. Raises `FitError`
    for a pattern that matches nothing, and for a plain name whose coefficient cannot change the image.
    """
    if isinstance(patterns, str):
        patterns = (patterns,)
    if not patterns:
        raise FitError('free: no coefficient is free; name some, such as free=["glass.k_d"] or "*.k_s"')
    known = [f"{material}.{row.name}" for material in scene.materials for row in COEFFICIENTS]
    chosen, plain = [], set()
    for pattern in patterns:
        matches = [pattern] if pattern in known else [name for name in known if fnmatch.fnmatchcase(name, pattern)]
        if not matches:
            raise FitError(
                f"free: {pattern!r} matches no coefficient; names are MATERIAL.COEFFICIENT with materials "
                f"{', '.join(scene.materials)} and coefficients {', '.join(BY_NAME)}.{nearest_name(pattern, known)}"
            )
        chosen += matches
        plain |= {pattern} & set(known)
    names = [name for name in known if name in chosen]
    idle = {name: why for name in names if (why := _without_effect(scene, name, names, max_depth or scene.max_depth))}
    for name in sorted(plain & set(idle)):
        raise FitError(
            f"free: {name} = {_shown(coefficient_value(scene, name))} has no effect on the image: {idle[name]}"
        )
    names = [name for name in names if name not in idle]
    if not names:
        raise FitError(
            f"free: nothing that {', '.join(patterns)} matches has an effect on the image: "
            + "; ".join(f"{name}: {why}" for name, why in list(idle.items())[:4])
        )
    return tuple(names), tuple(idle.items())


def list_unknowns(
    scene: Scene, names: Sequence[str], bounds: Mapping[str, tuple[float, float]] | None = None
) -> tuple[Unknown, ...]:
    """One unknown a coefficient, three where it is linear RGB in the scene. `bounds` may use wildcards."""
    unknowns = []
    for name in names:
        row = BY_NAME[name.rpartition(".")[2]]
        channels = range(3) if jnp.shape(coefficient_value(scene, name)) == (3,) else (None,)
        ends = _default_bounds(row, np.asarray(coefficient_value(scene, name)))
        unknowns += [Unknown(name, channel, row, ends) for channel in channels]
    for pattern, ends in (bounds or {}).items():
        matched = _matching(unknowns, pattern)
        if not matched:
            raise FitError(
                f"bounds: {pattern!r} matches no free coefficient; free are {', '.join(u.name for u in unknowns)}"
            )
        for i in matched:
            unknowns[i] = Unknown(
                unknowns[i].coefficient, unknowns[i].channel, unknowns[i].row, _checked_bounds(unknowns[i], ends)
            )
    return tuple(unknowns)


def start_values(scene: Scene, unknowns: tuple[Unknown, ...], start: Mapping[str, float] | None = None) -> np.ndarray:
    """Where the fit begins: the scene's values, replaced by those in `start` (names, with wildcards).

    Raises `FitError` for a start outside the bounds and for a name that is not free.
    """
    values = np.asarray(
        [np.asarray(coefficient_value(scene, u.coefficient)).reshape(-1)[u.channel or 0] for u in unknowns], np.float64
    )
    for pattern, value in (start or {}).items():
        matched = _matching(unknowns, pattern)
        if not matched:
            raise FitError(
                f"start: {pattern!r} matches no free coefficient; free are {', '.join(u.name for u in unknowns)}"
            )
        values[matched] = _start_number(pattern, value)
    for u, value in zip(unknowns, values, strict=True):
        low, high = u.bounds
        slack = 1e-6 * (high - low)
        at_the_end_of_a_log = u.row.scale != "interval" and value == u.row.lowest
        if not low - slack <= value <= high + slack and not at_the_end_of_a_log:
            raise FitError(
                f"start: {u.name} = {value:g} is outside its bounds {low:g} to {high:g}; start inside, or widen them "
                f"with bounds={{{u.name!r}: (low, high)}} (diffwhitted fit --bounds {u.name}=LOW:HIGH)"
            )
    return np.clip(values, *np.asarray([u.bounds for u in unknowns]).T)


def insert(scene: Scene, unknowns: tuple[Unknown, ...], values: Float[Array | np.ndarray, "p"]) -> Scene:
    """The scene with the values of the unknowns; differentiable."""
    for name in dict.fromkeys(u.coefficient for u in unknowns):
        mine = [i for i, u in enumerate(unknowns) if u.coefficient == name]
        value = values[mine[0]] if unknowns[mine[0]].channel is None else values[np.asarray(mine)]
        scene = replace_coefficient(scene, name, value)
    return scene


def _default_bounds(row: Row, value: np.ndarray) -> tuple[float, float]:
    """The bounds of the table, widened (twice as far as need be) where the scene's own value lies outside."""
    low, high = row.fit_bounds
    if row.lowest < value.min() < low:
        low = row.lowest + 0.5 * (float(value.min()) - row.lowest)
    return low, max(high, min(2 * float(value.max()), row.highest)) if value.max() > high else high


def _matching(unknowns: Sequence[Unknown], pattern: str) -> list[int]:
    """The numbers of the unknowns of that very name or, where there is none, of those that match it as a pattern."""
    exact = [i for i, u in enumerate(unknowns) if pattern in (u.name, u.coefficient)]
    return exact or [
        i for i, u in enumerate(unknowns) if any(fnmatch.fnmatchcase(name, pattern) for name in (u.name, u.coefficient))
    ]


def _start_number(name: str, value) -> float:
    if np.ndim(value) or not _are_numbers([value]):
        raise FitError(
            f"start: {name} = {value!r}; allowed is a number, and for one channel of a colour its own name, such "
            f"as {name}.r"
        )
    return float(value)


def _are_numbers(values) -> bool:
    try:
        return all(np.isfinite(float(value)) and not isinstance(value, str) for value in values)
    except (TypeError, ValueError):
        return False


def _checked_bounds(unknown: Unknown, ends) -> tuple[float, float]:
    if np.shape(ends) != (2,) or not _are_numbers(ends):
        raise FitError(f"bounds: {unknown.name} = {ends!r}; allowed is (low, high), two finite numbers")
    low, high = map(float, ends)
    floor = {"interval": unknown.row.lowest, "log": 0.0, "log-excess": 1.0}[unknown.row.scale]
    open_end = unknown.row.scale != "interval"
    if not (low < high <= unknown.row.highest and (low > floor if open_end else low >= floor)):
        end = f" and high <= {unknown.row.highest:g}" if np.isfinite(unknown.row.highest) else ""
        raise FitError(
            f"bounds: {unknown.name} = {low:g} to {high:g}; allowed is low < high with low "
            f"{'>' if open_end else '>='} {floor:g}{end}"
        )
    return low, high


def _without_effect(scene: Scene, name: str, free: Sequence[str], max_depth: int) -> str | None:
    """Why a coefficient cannot change the image whatever its value, or None."""
    material, _, coefficient = name.rpartition(".")
    record = scene.materials[material]

    def at_work(other: str) -> bool:
        value = record.highlight_coefficient() if other == "k_h" else getattr(record, other)
        follows = other == "k_h" and record.k_h is None and f"{material}.k_s" in free
        return f"{material}.{other}" in free or follows or bool(np.any(np.asarray(value) > 0))

    if not any(o.material == material for o in scene.objects):
        return f"no object is made of {material!r}"
    if coefficient in ("k_d", "k_h", "phong_exponent") and not scene.lights:
        return "the scene has no light; add a [[light]]"
    if coefficient == "k_a" and not np.any(np.asarray(scene.ambient) > 0):
        return "ambient = 0; raise it, or fix k_a"
    if coefficient in ("k_h", "phong_exponent") and record.highlight == "off":
        return f'material {material!r} has highlight = "off"; choose "halfway" or "reflected"'
    if coefficient == "phong_exponent" and not at_work("k_h"):
        return f"{material}.k_h = 0, so there is no highlight; give k_h a value or free it too"
    if coefficient == "refractive_index" and not at_work("k_t"):
        return f"{material}.k_t = 0, so no light passes through; give k_t a value or free it too"
    if coefficient in ("k_t", "refractive_index", "k_s") and max_depth == 1:
        if coefficient == "k_s" and record.k_h is None and record.highlight != "off" and scene.lights:
            return None
        return "max_depth = 1: there are only camera rays; raise max_depth"
    return None


def _shown(value) -> str:
    return np.array2string(np.asarray(value), precision=4, separator=", ", legacy=False)
