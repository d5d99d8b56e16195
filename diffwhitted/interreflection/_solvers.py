"""Three ways to solve (I - rho F) B = E for the radiosity B of patches (Hearn and Baker 14-74, 14-75), one a channel.

All give the same B, differentiable in rho and E, forward and in reverse, by the derivative of the equations: what is
differentiated is the answer, not the way to it. A_j F_jk = A_k F_kj makes the transposed equations ones of the same
kind: (I - F^T rho) x = b has x = A (c + F z), with c = b / A and z the solution for E = rho c.
"""

from collections.abc import Callable
from typing import Literal, get_args

import jax
import jax.numpy as jnp
import lineax
from jaxtyping import Array, Float, Int

Solver = Literal["direct", "gauss-seidel", "progressive"]
SOLVERS: tuple[str, ...] = get_args(Solver)
MOST_SWEEPS = 2000
"""Of Gauss and Seidel, or as many times the patches of shots: what has not settled by then is NaN."""

Light = Float[Array, "n 3"]


def solve(
    matrix: Float[Array, "n n"], area: Float[Array, "n"], rho: Light, emitted: Light, solver: str = "progressive"
) -> Light:
    """B of patches that reflect `rho` and send `emitted` of their own; NaN where it does not settle or no light is
    absorbed. Derivatives in `rho` and `emitted`; `matrix` and `area` have none.
    """
    matrix, area = (jax.lax.stop_gradient(jnp.asarray(a, emitted.dtype)) for a in (matrix, area))
    way = WAYS[solver]

    def unlit(b: Light) -> Light:
        return b - rho * (matrix @ b)

    def forwards(_, emitted):
        return way(matrix, area, jax.lax.stop_gradient(rho), emitted)

    def transposed(_, wanted):
        c = wanted / area[:, None]
        held = jax.lax.stop_gradient(rho)
        return area[:, None] * (c + matrix @ way(matrix, area, held, held * c))

    return jax.lax.custom_linear_solve(unlit, emitted, forwards, transposed)


def direct(matrix, area, rho: Light, emitted: Light) -> Light:
    """By LU."""
    del area

    def channel(rho, emitted):
        equations = lineax.MatrixLinearOperator(jnp.eye(len(rho), dtype=rho.dtype) - rho[:, None] * matrix)
        return lineax.linear_solve(equations, emitted, lineax.LU(), throw=False).value

    return jax.vmap(channel, (1, 1), 1)(rho, emitted)


def gauss_seidel(matrix, area, rho: Light, emitted: Light) -> Light:
    """B_j = E_j + rho_j sum_k F_jk B_k, one patch after the other, the newest B at once."""
    del area
    enough = _enough(emitted)

    def sweep(state):
        b, _, count = state

        def one(j, b):
            return b.at[j].set(emitted[j] + rho[j] * (matrix[j] @ b))

        new = jax.lax.fori_loop(0, len(b), one, b)
        return new, abs(new - b).max(), count + 1

    def going_on(state):
        _, change, count = state
        return (change > enough) & (count < MOST_SWEEPS)

    first = emitted, jnp.full((), jnp.inf, emitted.dtype), jnp.int32(0)
    b, change, _ = jax.lax.while_loop(going_on, sweep, first)
    return jnp.where(change <= enough, b, jnp.nan)


def progressive(matrix, area, rho: Light, emitted: Light) -> Light:
    """The patch with the most unshot light sends it to all others, again and again (Hearn and Baker 14-83)."""
    enough = _enough(emitted)
    b, unshot, _ = _shots(matrix, area, rho, emitted, MOST_SWEEPS * len(area), enough)
    return jnp.where(abs(unshot).max() <= enough, b, jnp.nan)


def after_shots(matrix, area, rho: Light, emitted: Light, shots: int) -> tuple[Light, Light]:
    """B after so many shots, and the same with the ambient estimate of the light that is yet to be shot.

    That is rho_j R sum A dB / sum A, R = 1 / (1 - mean of rho by area): the unshot light as if it were even.
    """
    b, unshot, _ = _shots(matrix, area, rho, emitted, shots, jnp.zeros((), emitted.dtype))
    share = (area / area.sum())[:, None]
    even = (share * unshot).sum(axis=0) / (1 - (share * rho).sum(axis=0))
    return b, b + rho * even


def _shots(matrix, area, rho: Light, emitted: Light, most: int | Int[Array, ""], enough):
    def shoot(state):
        b, unshot, count = state
        j = jnp.argmax(area * abs(unshot).sum(axis=1))
        # rho_k F_kj dB_j = rho_k F_jk dB_j A_j / A_k: a row of F, which lies together in memory.
        arrives = rho * (matrix[j] * area[j] / area)[:, None] * unshot[j]
        return b + arrives, unshot.at[j].set(0) + arrives, count + 1

    def going_on(state):
        _, unshot, count = state
        return (abs(unshot).max() > enough) & (count < most)

    return jax.lax.while_loop(going_on, shoot, (emitted, emitted, jnp.int32(0)))


def _enough(emitted: Light):
    """The unshot light, or the change, that is none: some rounding errors of the largest."""
    size = jnp.finfo(emitted.dtype).eps * 4 if emitted.dtype == jnp.float32 else 1e-12
    return size * abs(emitted).max()


WAYS: dict[str, Callable[..., Light]] = {
    "direct": direct, "gauss-seidel": gauss_seidel, "progressive": progressive,
}  # fmt: skip
