"""The least-squares problem of a fit: residuals of the replay, and their Jacobian as a small factor.

For the weighted residuals r (one a channel and pixel) and their Jacobian J in the coefficients, all that
Levenberg-Marquardt and the uncertainties need is the triangular factor of [J r]:

    [J r] = Q [[R, q], [0, rho]],   so J'J = R'R,  J'r = R'q,  |r|^2 = |q|^2 + rho^2.

Each pass of a picture gives such a factor of its own rows, on whichever processor is free, and the factor of
the factors is that of them all. The memory is that of the passes at work, whatever the size of the target.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from diffwhitted.numerics._workers import processors, side_by_side
from diffwhitted.scene import Scene

from ._bounds import Bounds
from ._filtering import Filtering
from ._nameless import shots_alone, without_shots
from ._priors import Priors
from ._pyramid import blurred
from ._rows import factor_of_rows, picture_rows, radiance_rows, record_part
from ._sight import of_shots
from ._unknowns import Unknown
from ._views import Part, View


class Problem(eqx.Module):
    """Scene, unknowns and targets of a fit."""

    scene: Scene
    """As its programs know it: without names (see `_nameless`), its shots those of the targets."""
    bounds: Bounds
    views: tuple[View, ...]
    """The targets."""
    unknowns: tuple[Unknown, ...] = eqx.field(static=True)
    nameless: tuple[Unknown, ...] = eqx.field(static=True, default=())
    """The unknowns, as its programs know them, with those that follow others."""
    ties: Float[np.ndarray, "q p"] | None = None
    """The values of all of those, from the unknowns'; None: they are the unknowns'."""
    priors: Priors | None = None

    @property
    def moves(self) -> bool:
        """Does any of the unknowns move rays, shadows or patterns?"""
        return any_moves(self.nameless or self.unknowns)

    def all_values(self, values):
        """The values of those that follow too."""
        return values if self.ties is None else jnp.asarray(self.ties, self.scene.dtype) @ values

    def asked(self, values) -> "Asked":
        """What its programs are asked for at these values."""
        return Asked.of(self.scene, self.nameless, jnp.asarray(self.all_values(values), self.scene.dtype))

    def prior_loss(self, values: np.ndarray) -> float:
        """The part of priors in |r|^2 / 2."""
        return 0.0 if self.priors is None else self.priors.loss(values)

    def prior_errors(self, ways: np.ndarray, factor: np.ndarray, noise: float, precision: float) -> np.ndarray:
        """Standard errors along some ways where there are priors, else 0."""
        if self.priors is None or not np.isfinite(noise):
            return np.zeros(ways.shape[1])
        return self.priors.errors(ways, factor, noise, precision)

    def joined(self, rows: np.ndarray, names: list[int]) -> np.ndarray:
        """Rows of a part's columns (m, ...) as those of the unknowns (p, ...); `names`: `Asked.columns_of`."""
        whole = np.zeros((len(self.nameless), *rows.shape[1:]), rows.dtype)
        mine = [k for k, name in enumerate(names) if name >= 0]
        whole[[names[k] for k in mine]] = rows[mine]
        return whole if self.ties is None else np.tensordot(self.ties.T, whole, 1)


def any_moves(unknowns: tuple[Unknown, ...]) -> bool:
    return any(u.moves for u in unknowns)


@dataclass(frozen=True)
class Asked:
    """A scene, its unknowns and their values, parted into what its light depends on and what its shots make of it."""

    scene: Scene
    unknowns: tuple[Unknown, ...]
    values: Float[Array, "q"]
    shots: Scene
    of_shots: tuple[Unknown, ...]
    shot_values: Float[Array, "s"]
    numbers: tuple[list[int], list[int]]
    """Of the unknowns of the scene and of those of shots, among all."""

    @staticmethod
    def of(scene: Scene, unknowns: tuple[Unknown, ...], values: Float[Array, "p"]) -> "Asked":
        mine, theirs = of_shots(unknowns, False), of_shots(unknowns)
        return Asked(
            without_shots(scene),
            tuple(unknowns[i] for i in mine),
            values[np.asarray(mine, int)],
            shots_alone(scene),
            tuple(unknowns[i] for i in theirs),
            values[np.asarray(theirs, int)],
            (mine, theirs),
        )

    def rows(self, part: Part):
        """The light of a part with its derivatives, and the room for rays that it needs."""
        return radiance_rows(self.scene, self.unknowns, self.values, part)

    def picture(self, part: Part, columns, seen):
        """The rows [J r] of a part, and what it shows."""
        return picture_rows(self.shots, self.of_shots, self.shot_values, _without_trees(part), columns, seen)

    def columns_of(self, part: Part) -> list[int]:
        """The numbers, among all unknowns, of the columns of a part's rows; -1 for those that are none."""
        numbers = []
        for mine, free in zip(self.numbers, (part.sight.free, part.sight.free_shot), strict=True):
            numbers += [mine[k] if k < len(mine) else -1 for k in np.asarray(free).tolist()]
        return numbers


def _without_trees(part: Part) -> Part:
    """What the picture of a part is made of, whatever its rays: so one program serves all."""
    return replace(part, trees=None, plan=replace(part.plan, capacity=0))


def prepared(scene: Scene, unknowns: tuple[Unknown, ...], values, views: tuple[View, ...], moving: bool):
    """The views with room for their rays and, unless rays move, with their trees; all their programs are compiled.

    Views of one kind have the same room, so that they share their programs.
    """
    asked, ready = Asked.of(scene, unknowns, values), []
    kinds: dict = {}
    for number, view in enumerate(views):
        kinds.setdefault((view.parts[0].plan, jax.tree.structure(view.parts[0])), []).append(number)
    for members in kinds.values():
        parts = tuple(part for number in members for part in views[number].parts)
        parts = iter((_roomy if moving else _recorded)(asked, parts))
        ready += [(n, replace(views[n], parts=tuple(next(parts) for _ in views[n].parts))) for n in members]
    return tuple(view for _, view in sorted(ready, key=lambda pair: pair[0]))


def _recorded(asked: Asked, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """The parts with their trees, and room for them."""
    while True:
        with ThreadPoolExecutor(1) as aside:
            shape = eqx.filter_eval_shape(record_part, asked.scene, asked.unknowns, asked.values, parts[0])
            blank = replace(parts[0], trees=jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), shape))
            compiling = aside.submit(_factor_of_part, asked, blank)
            recorded = side_by_side(
                lambda part: replace(part, trees=record_part(asked.scene, asked.unknowns, asked.values, part)), parts
            )
            compiling.result()
        needed = max(int(part.trees.descendants.max()) for part in recorded if part.trees is not None)
        if needed <= parts[0].plan.capacity:
            return tuple(recorded)
        parts = tuple(replace(part, plan=part.plan.with_capacity(2 * needed)) for part in parts)


def _factor_of_part(asked: Asked, part: Part):
    """All programs of a part, once."""
    return factor_of_rows(asked.picture(part, *asked.rows(part)[:2])[0])


def _roomy(asked: Asked, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """The parts with room for their rays at these coefficients; the same for all, so that they share a program."""
    while True:
        needed = max(int(found[2]) for found in side_by_side(asked.rows, parts))
        if needed <= parts[0].plan.capacity:
            _factor_of_part(asked, parts[0])
            return parts
        room = parts[0].plan.with_capacity(3 * needed // 2)
        parts = tuple(replace(part, plan=room) for part in parts)


def factorise(
    problem: Problem, values: Float[Array | np.ndarray, "p"], sigma: float = 0.0
) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """The triangular factor of [J r] in the coefficients, (p + 1, p + 1), and the film of each target.

    The pictures are in the precision of the scene, the factor of the parts' factors in float64; priors are rows of it.
    With `sigma` residual and Jacobian are blurred by so many pixels (see `_pyramid`).
    """
    count, asked = len(problem.nameless), problem.asked(values)
    factors, films = [], []
    for view in problem.views:
        names = [*asked.columns_of(view.parts[0]), count]
        if sigma:
            rows, film = zip(*pass_rows(asked, view, lambda rows: np.asarray(rows)), strict=True)
            found = [_blurred_factor(view, np.stack(rows), sigma)]
        else:
            found, film = zip(*pass_rows(asked, view, factor_of_rows), strict=True)
        factors += [_spread(np.asarray(factor, np.float64), names, count + 1) for factor in found]
        films.append(np.stack(film))
    rows = np.concatenate(factors)
    if problem.ties is not None:
        rows = np.concatenate([rows[:, :-1] @ problem.ties, rows[:, -1:]], axis=1)
    if problem.priors is not None:
        rows = np.concatenate([rows, problem.priors.rows(np.asarray(values))])
    return _factor_of(rows), tuple(films)


def pass_rows(asked: Asked, view: View, use: Callable = lambda rows: rows) -> Iterator[tuple]:
    """Of each pass of a view, `use` of its rows [J r], (m + 1, 3, pixels), and what it shows."""
    if view.filter != "box":
        yield from _filtered_rows(asked, view, use)
        return

    def one_pass(number: int, follow: Callable):
        parts = view.places_of(number)
        found = follow(lambda part: with_room(asked.rows, part), parts)
        columns, seen = found[0] if len(found) == 1 else jax.tree.map(lambda *a: sum(a) / len(a), *found)
        rows, picture = asked.picture(parts[0], columns, seen)
        return use(rows), np.asarray(picture)

    if view.passes >= processors():
        yield from side_by_side(
            lambda number: one_pass(number, lambda f, parts: list(map(f, parts))), range(view.passes)
        )
    else:
        for number in range(view.passes):
            yield one_pass(number, side_by_side)


def _filtered_rows(asked: Asked, view: View, use: Callable) -> Iterator[tuple]:
    """The same where pixels see samples around them: all samples are traced first, place by place."""
    gathering = Filtering(view.filter, *view.weight.shape[:2])
    for first in range(0, len(view.parts), view.passes):
        parts = view.parts[first : first + view.passes]
        found = side_by_side(lambda part: with_room(asked.rows, part), parts)
        film = jnp.stack(
            [jnp.concatenate([columns, seen[None]]).reshape(-1, seen.shape[-1]) for columns, seen in found]
        )
        gathering.add_passes(film, np.asarray(parts[0].place).tolist())
    film = gathering.passes(view.passes, view.parts[0].weight.shape[-1])
    for part, lights in zip(view.parts, film, strict=False):
        lights = lights.reshape(-1, 3, lights.shape[-1])
        rows, picture = asked.picture(part, lights[:-1], lights[-1])
        yield use(rows), np.asarray(picture)


def _spread(factor: np.ndarray, names: list[int], count: int) -> np.ndarray:
    """A factor of some columns as one of all."""
    whole = np.zeros((len(factor), count))
    mine = [k for k, name in enumerate(names) if name >= 0]
    whole[:, [names[k] for k in mine]] = factor[:, mine]
    return whole


def _blurred_factor(view: View, passes: np.ndarray, sigma: float) -> np.ndarray:
    """The factor of a target's rows, blurred by so many pixels of the camera."""
    picture = np.asarray(view.picture(passes.reshape(passes.shape[0], -1, passes.shape[-1])))
    picture = np.moveaxis(picture, -1, 0).reshape(-1, 3, *picture.shape[:2])
    return _factor_of(blurred(picture, sigma / view.step).reshape(picture.shape[0], -1).T)


def with_room(rows: Callable, part: Part):
    """The light of a part and its derivatives, with more room where moving rays need it."""
    while True:
        columns, seen, needed = rows(part)
        if int(needed) <= part.plan.capacity:
            return columns, seen
        part = replace(part, plan=part.plan.with_capacity(2 * int(needed)))


def _factor_of(factors: np.ndarray) -> np.ndarray:
    """The triangular factor of stacked ones, with a diagonal >= 0; square also where there are few rows."""
    total = np.asarray(np.linalg.qr(np.vstack([factors, np.zeros((factors.shape[1],) * 2)]), mode="r"))
    return total * np.where(np.diagonal(total) < 0, -1, 1)[:, None]
