"""The programs of a fit: from one pass of a target to its rows [J r], in the unknowns that it depends on.

`radiance_rows` traces one sample a pixel; the samples of a pixel are averaged outside; `picture_rows` makes of light
what the shot shows of it; `triangular` takes the factor. They are the same for all shots of a kind.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from diffwhitted.numerics._kept import kept
from diffwhitted.scene import Scene, from_middle
from diffwhitted.tree import Record, record, replay

from ._unknowns import Unknown, insert
from ._views import Part

ROWS = 4096


@kept
def radiance_rows(scene: Scene, unknowns: tuple[Unknown, ...], values: Float[Array, "q"], part: Part):
    """The derivatives of a part's light in the unknowns that it depends on, (m, 3, pixels), the light, and the room for
    rays that it needs.
    """
    trees = part.trees if part.trees is not None else record_part(scene, unknowns, values, part)
    free = part.sight.free
    ways = jnp.zeros((free.shape[0], len(unknowns)), values.dtype)
    ways = ways.at[jnp.arange(free.shape[0]), free].set(1, mode="drop")

    def light(values):
        inserted = insert(scene, unknowns, values)
        tables, camera = part.sight.tables_of(inserted, part.marks), part.sight.camera_of(inserted)
        return replay(tables, camera, trees, part.plan, part.samples, forward=True).stacked(axis=0)

    seen, columns = _value_and_columns(light, values, ways)
    return columns, seen, trees.descendants.max()


@kept
def picture_rows(shots: Scene, unknowns: tuple[Unknown, ...], values: Float[Array, "s"], part: Part, columns, seen):
    """The rows [J r] of a part, (m + s + 1, 3, pixels), and what its shot shows of its light `seen`, whose derivatives
    are `columns`.
    """
    across, down = from_middle(part.column + 0.5, part.row + 0.5, *part.plan.picture)
    free = part.sight.free_shot

    def shown(values, light):
        shot = part.sight.shot_of(insert(shots, unknowns, values))
        return shot.shown(light, across, down)

    picture, along = jax.linearize(shown, values, seen)
    ways = jnp.zeros((free.shape[0], len(unknowns)), values.dtype)
    ways = ways.at[jnp.arange(free.shape[0]), free].set(1, mode="drop")
    by_light = jax.vmap(lambda column: along(jnp.zeros_like(values), column))(columns)
    by_shot = jax.vmap(lambda way: along(way, jnp.zeros_like(seen)))(ways)
    residual = (picture - part.target) * part.weight
    rows = jnp.concatenate([jnp.concatenate([by_light, by_shot]) * part.weight, residual[None]])
    return rows, picture


@kept
def record_part(scene: Scene, unknowns: tuple[Unknown, ...], values, part: Part) -> Record:
    """The trees of a part at these coefficients.

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
    tables, camera = part.sight.tables_of(inserted, part.marks), part.sight.camera_of(inserted)
    return record(tables, camera, part.plan, part.samples)


def _value_and_columns(fn, values: Float[Array, "p"], ways: Float[Array, "m p"]):
    """fn(values) and its derivative along each way, in forward mode."""

    def along(way):
        return jax.jvp(fn, (values,), (way,))

    if not len(ways):
        value = fn(values)
        return value, jnp.zeros((0, *value.shape), value.dtype)
    if len(ways) == 1:  # a batch of one would be traced and compiled for nothing
        value, column = along(ways[0])
        return value, column[None]
    return jax.vmap(along, out_axes=(None, 0))(ways)


def factor_of_rows(rows: Float[Array, "columns 3 pixels"]) -> Float[Array, "columns columns"]:
    return triangular(rows.reshape(rows.shape[0], -1))


@kept
def triangular(rows: Float[Array, "columns rows"]) -> Float[Array, "columns columns"]:
    """R of the QR factors of the transpose, by blocks of rows that fit the cache."""
    columns, count = rows.shape
    blocks = -(-count // ROWS)
    rows = jnp.pad(rows, ((0, 0), (0, blocks * ROWS - count)))
    tall = rows.reshape(columns, blocks, ROWS).transpose(1, 2, 0)
    factors = jax.lax.map(lambda block: jnp.linalg.qr(block, mode="r"), tall)
    return jnp.linalg.qr(factors.reshape(-1, columns), mode="r")
