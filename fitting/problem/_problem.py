"""The least-squares problem of a fit: residuals of the replay, and their Jacobian as a small factor.

For the weighted residuals r (one a channel and pixel) and their Jacobian J in the coefficients, all that
Levenberg-Marquardt and the uncertainties need is the triangular factor of [J r]:

    [J r] = Q [[R, q], [0, rho]],   so J'J = R'R,  J'r = R'q,  |r|^2 = |q|^2 + rho^2.

Each pass of a picture gives such a factor of its own rows, on whichever processor is free, and the factor of
the factors is that of them all. The memory is that of the passes at work, whatever the size of the target.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from diffwhitted.numerics._kept import kept
from diffwhitted.numerics._workers import side_by_side
from diffwhitted.scene import Scene, tabulate
from diffwhitted.tree import Record, record, replay

from ._bounds import Bounds
from ._pyramid import blurred
from ._unknowns import Unknown, insert
from ._views import Part, View

ROWS = 4096


class Problem(eqx.Module):
    """Scene, unknowns and targets of a fit."""

    scene: Scene
    """As its programs know it: without names (see `_nameless`)."""
    bounds: Bounds
    views: tuple[View, ...]
    """The targets."""
    unknowns: tuple[Unknown, ...] = eqx.field(static=True)
    nameless: tuple[Unknown, ...] = eqx.field(static=True, default=())
    """The unknowns, as its programs know them."""

    @property
    def moves(self) -> bool:
        """Does any of the unknowns move rays, shadows or patterns?"""
        return any_moves(self.unknowns)


def any_moves(unknowns: tuple[Unknown, ...]) -> bool:
    return any(u.moves for u in unknowns)


def prepared(scene: Scene, unknowns: tuple[Unknown, ...], values, view: View, moving: bool) -> View:
    """The view with room for its rays and, unless rays move, with their trees; all their programs are compiled."""
    ready = _roomy if moving else _recorded
    return replace(view, parts=ready(scene, unknowns, values, view.parts))


def _recorded(scene: Scene, unknowns: tuple[Unknown, ...], values, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """The parts with their trees, and room for them."""
    while True:
        with ThreadPoolExecutor(1) as aside:
            blank = jax.tree.map(
                lambda a: jnp.zeros(a.shape, a.dtype),
                eqx.filter_eval_shape(record_part, scene, unknowns, values, parts[0]),
            )
            compiling = aside.submit(part_factor, scene, unknowns, values, replace(parts[0], trees=blank))
            recorded = side_by_side(lambda part: replace(part, trees=record_part(scene, unknowns, values, part)), parts)
            compiling.result()
        needed = max(int(part.trees.descendants.max()) for part in recorded if part.trees is not None)
        if needed <= parts[0].plan.capacity:
            return tuple(recorded)
        parts = tuple(replace(part, plan=part.plan.with_capacity(2 * needed)) for part in parts)


def _roomy(scene: Scene, unknowns: tuple[Unknown, ...], values, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """The parts with room for their rays at these coefficients; the same for all, so that they share a program."""
    while True:
        needed = max(
            int(found[2]) for found in side_by_side(lambda part: part_rows(scene, unknowns, values, part), parts)
        )
        if needed <= parts[0].plan.capacity:
            return parts
        room = parts[0].plan.with_capacity(3 * needed // 2)
        parts = tuple(replace(part, plan=room) for part in parts)


def factorise(
    problem: Problem, values: Float[Array | np.ndarray, "p"], sigma: float = 0.0
) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """The triangular factor of [J r] in the coefficients, (p + 1, p + 1), and the film of each target.

    The pictures are in the precision of the scene, the factor of the parts' factors in float64. With `sigma` residual
    and Jacobian are blurred by so many pixels (see `_pyramid`).
    """
    values = jnp.asarray(values, problem.scene.dtype)
    parts = [part for view in problem.views for part in view.parts]
    program = part_rows if parts[0].trees is None else part_factor
    found = side_by_side(lambda part: _with_room(program, problem.scene, problem.nameless, values, part), parts)
    factors, films = zip(*found, strict=True)
    films = _by_view(problem, films)
    if program is part_rows:
        rows = _by_view(problem, factors)
        factors = (
            _blurred_factors(problem, rows, sigma)
            if sigma
            else [_triangular(r.reshape(r.shape[0], -1)) for passes in rows for r in passes]
        )
    return _factor_of(np.concatenate([np.asarray(f) for f in factors]).astype(np.float64)), films


def _by_view(problem: Problem, found: Sequence[Array | np.ndarray]) -> tuple[np.ndarray, ...]:
    """What was found out about each part, (passes, ...) for each target, averaged over the samples a pixel."""
    rest = iter(found)
    views = ((view.passes, np.stack([next(rest) for _ in view.parts])) for view in problem.views)
    return tuple(parts.reshape(-1, passes, *parts.shape[1:]).mean(axis=0) for passes, parts in views)


def _blurred_factors(problem: Problem, rows: tuple[np.ndarray, ...], sigma: float) -> list[np.ndarray]:
    """The factor of each target's rows, blurred by so many pixels of the camera."""
    factors = []
    for view, passes in zip(problem.views, rows, strict=True):
        picture = np.asarray(view.picture(passes.reshape(passes.shape[0], -1, passes.shape[-1])))
        picture = np.moveaxis(picture, -1, 0).reshape(-1, 3, *picture.shape[:2])
        factors.append(_factor_of(blurred(picture, sigma / view.step).reshape(picture.shape[0], -1).T))
    return factors


def _with_room(program, scene: Scene, unknowns: tuple[Unknown, ...], values, part: Part):
    """What a program finds out about a part, and its film, with more room where moving rays need it."""
    while True:
        found, film, needed = program(scene, unknowns, values, part)
        if int(needed) <= part.plan.capacity:
            return found, film
        part = replace(part, plan=part.plan.with_capacity(2 * int(needed)))


@kept
def part_factor(scene: Scene, unknowns: tuple[Unknown, ...], values: Float[Array, "p"], part: Part):
    """The triangular factor of [J r] of one part, its rendered pixels (3, pixels), and the room for rays that it
    needs.
    """
    rows, seen, needed = part_rows(scene, unknowns, values, part)
    return _triangular(rows.reshape(len(unknowns) + 1, -1)), seen, needed


@kept
def part_rows(scene: Scene, unknowns: tuple[Unknown, ...], values: Float[Array, "p"], part: Part):
    """The rows [J r] of one part, (p + 1, 3, pixels), its rendered pixels, and the room for rays that it needs."""
    trees = part.trees if part.trees is not None else record_part(scene, unknowns, values, part)
    seen, columns = _value_and_columns(lambda values: _film(insert(scene, unknowns, values), part, trees), values)
    residual = (seen - part.target) * part.weight
    rows = jnp.concatenate([columns * part.weight, residual[None]])
    return rows, seen, trees.descendants.max()


@kept
def record_part(scene: Scene, unknowns: tuple[Unknown, ...], values, part: Part) -> Record:
    """The trees of a part at these coefficients, one a sample.

    Where branches are cut off by their throughput, free k_s and k_t count with the most that they may become, so
    that no branch comes or goes as a fit moves them and the residual does not jump.
    """
    values = jax.lax.stop_gradient(values)
    if part.plan.effects.cutoff:
        values = jnp.stack(
            [
                jnp.asarray(u.bounds[1], values.dtype)
                if u.parameter.family == "material" and u.row.name in ("k_s", "k_t")
                else v
                for u, v in zip(unknowns, values, strict=True)
            ]
        )
    inserted = insert(scene, unknowns, values)
    tables, camera = tabulate(inserted, part.marks), inserted.cameras[part.camera]
    return jax.lax.map(lambda place: record(tables, camera, part.plan, part.samples(place)), part.places)


def _film(scene: Scene, part: Part, trees: Record) -> Float[Array, "3 pixels"]:
    """The pixels of one part, averaged over the samples."""
    tables, camera = tabulate(scene, part.marks), scene.cameras[part.camera]

    def one_sample(sample):
        tree, place = sample
        return replay(tables, camera, tree, part.plan, part.samples(place), forward=True).stacked(axis=0)

    return jax.lax.map(one_sample, (trees, part.places)).mean(axis=0)


def _value_and_columns(fn, values: Float[Array, "p"]):
    """fn(values) and its derivative along each coefficient, in forward mode."""

    def along(tangent):
        return jax.jvp(fn, (values,), (tangent,))

    if values.size == 1:  # a batch of one would be traced and compiled for nothing
        value, column = along(jnp.ones_like(values))
        return value, column[None]
    return jax.vmap(along, out_axes=(None, 0))(jnp.eye(values.size, dtype=values.dtype))


@kept
def _triangular(rows: Float[Array, "columns rows"]) -> Float[Array, "columns columns"]:
    """R of the QR factors of the transpose, by blocks of rows that fit the cache."""
    columns, count = rows.shape
    blocks = -(-count // ROWS)
    rows = jnp.pad(rows, ((0, 0), (0, blocks * ROWS - count)))
    tall = rows.reshape(columns, blocks, ROWS).transpose(1, 2, 0)
    factors = jax.lax.map(lambda block: jnp.linalg.qr(block, mode="r"), tall)
    return jnp.linalg.qr(factors.reshape(-1, columns), mode="r")


def _factor_of(factors: np.ndarray) -> np.ndarray:
    """The triangular factor of stacked ones, with a diagonal >= 0; square also where there are few rows."""
    total = np.asarray(np.linalg.qr(np.vstack([factors, np.zeros((factors.shape[1],) * 2)]), mode="r"))
    return total * np.where(np.diagonal(total) < 0, -1, 1)[:, None]
