"""The least-squares problem of a fit: residuals of the replay, and their Jacobian as a small factor.

For the weighted residuals r (one a channel and pixel) and their Jacobian J in the coefficients, all that
Levenberg-Marquardt and the uncertainties need is the triangular factor of [J r]:

    [J r] = Q [[R, q], [0, rho]],   so J'J = R'R,  J'r = R'q,  |r|^2 = |q|^2 + rho^2.

It is accumulated pass by pass of the picture (a sequential QR), so the memory is that of one pass,
whatever the size of the target. The solver is given f = (q, rho) with Jacobian (R, 0) in place of r with J: the
same steps follow from it.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from diffwhitted.scene import Camera, Scene, tabulate
from diffwhitted.tree import Plan, Record, record, replay

from ._bounds import Bounds
from ._unknowns import Unknown, insert

ROWS = 4096


class View(eqx.Module):
    """A target as the solver reads it, in passes of the picture."""

    camera: Camera
    target: Float[Array, "passes 3 pixels"]
    weight: Float[Array, "passes pixels"]
    """Square root of the mask over the noise, divided by the root of the number of residuals."""
    trees: Record | None
    """The recorded trees (samples, passes); None where rays move, so that each evaluation records."""
    offsets: Float[Array, "samples 2"]
    plan: Plan = eqx.field(static=True)


class Problem(eqx.Module):
    """Scene, unknowns and views of a fit."""

    scene: Scene
    bounds: Bounds
    views: tuple[View, ...]
    unknowns: tuple[Unknown, ...] = eqx.field(static=True)


@eqx.filter_custom_jvp
def compressed(x: Float[Array, "p"], problem: Problem):
    """f = (q, rho) at the unknowns x, and the rendered passes of each view."""
    factor, films = factorise(problem, problem.bounds.values(x))
    return factor[:, -1], films


@compressed.def_jvp
def _compressed_jvp(primals, tangents):
    x, problem = primals
    factor, films = factorise(problem, problem.bounds.values(x))
    along = factor[:, :-1] @ (problem.bounds.slope(x) * tangents[0])
    return (factor[:, -1], films), (along, jax.tree.map(jnp.zeros_like, films))


@eqx.filter_jit
def factorise(problem: Problem, values: Float[Array, "p"]):
    """The triangular factor of [J r] in the coefficients, (p + 1, p + 1), and the films of the views.

    The pictures are in the precision of the scene, the factor in that of `values`.
    """
    count, precision = len(problem.unknowns), values.dtype
    values = values.astype(problem.scene.dtype)
    factor, films = jnp.zeros((count + 1, count + 1), values.dtype), []
    for view in problem.views:
        numbers = jnp.arange(view.plan.passes, dtype=jnp.int32)
        trees = view.trees if view.trees is not None else record_view(problem.scene, problem.unknowns, values, view)

        def one_pass(factor, inputs, view=view):
            number, target, weight, tree = inputs

            def film(values):
                return pass_film(insert(problem.scene, problem.unknowns, values), view, tree, number)

            seen, columns = _value_and_columns(film, values)
            residual = (seen - target) * weight
            rows = jnp.concatenate([columns * weight, residual[None]]).reshape(count + 1, -1)
            return _updated(factor, rows), seen

        factor, film = jax.lax.scan(one_pass, factor, (numbers, view.target, view.weight[:, None, :], _by_pass(trees)))
        films.append(film)
    return factor.astype(precision), tuple(films)


def pass_film(scene: Scene, view: View, trees: Record, number) -> Float[Array, "3 pixels"]:
    """The pixels of one pass, averaged over the samples."""
    tables = tabulate(scene)

    def one_sample(sample):
        tree, offset = sample
        film = replay(tables, view.camera, tree, view.plan, number, offset)
        return jnp.stack([film.x, film.y, film.z])

    return jax.lax.map(one_sample, (trees, view.offsets)).mean(axis=0)


@eqx.filter_jit
def record_view(scene: Scene, unknowns: tuple[Unknown, ...], values, view: View) -> Record:
    """The trees of a view at these coefficients, stacked (samples, passes)."""
    tables = tabulate(insert(scene, unknowns, jax.lax.stop_gradient(values)))
    numbers = jnp.arange(view.plan.passes, dtype=jnp.int32)

    def one_sample(offset):
        return jax.lax.map(lambda number: record(tables, view.camera, view.plan, number, offset), numbers)

    return jax.lax.map(one_sample, view.offsets)


def _by_pass(trees: Record) -> Record:
    return jax.tree.map(lambda a: jnp.swapaxes(a, 0, 1), trees)


def _value_and_columns(fn, values: Float[Array, "p"]):
    """fn(values) and its derivative along each coefficient, in forward mode."""

    def along(tangent):
        return jax.jvp(fn, (values,), (tangent,))

    return jax.vmap(along, out_axes=(None, 0))(jnp.eye(values.size, dtype=values.dtype))


def _updated(factor, rows: Float[Array, "columns rows"]):
    """The factor of the rows seen so far and these, by QR of blocks that fit the cache; its diagonal is >= 0."""
    columns, count = rows.shape
    blocks = -(-count // ROWS)
    rows = jnp.pad(rows, ((0, 0), (0, blocks * ROWS - count)))
    tall = rows.reshape(columns, blocks, ROWS).transpose(1, 2, 0)
    factors = jax.lax.map(lambda block: jnp.linalg.qr(block, mode="r"), tall)
    stacked = jnp.concatenate([factor, factors.reshape(-1, columns)])
    total = jnp.linalg.qr(stacked, mode="r")
    return total * jnp.where(jnp.diagonal(total) < 0, -1, 1)[:, None]
