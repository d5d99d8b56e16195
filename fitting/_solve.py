"""Optimistix's Levenberg-Marquardt, one step at a time, so that a person can watch it and stop it.

The solver looks at the residuals at one point a step. What it sees of them is their linear model there,

    f(x') = f + F (x' - x),   f = (q, rho),   F = (R dv/dx, 0)

with R, q and rho from `_problem`: the same steps follow from it as from all residuals and their Jacobian.
"""

import signal
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float

from ._problem import Problem, factorise
from ._result import FitStage, FitStep

REJECTIONS = 8
"""So many rejected steps in a row mean that the loss cannot fall any further in this precision."""


@dataclass(frozen=True)
class Solution:
    """Where one run of the solver ended, in coefficients."""

    values: np.ndarray
    factor: np.ndarray
    """R of the Jacobian in the coefficients, (p, p)."""
    remainder: np.ndarray
    """q of the residuals, (p,): the Gauss-Newton step is -R^-1 q."""
    loss: float
    """|r|^2 / 2 of the weighted residuals."""
    films: tuple[np.ndarray, ...]
    history: tuple[FitStep, ...]
    interrupted: bool
    seconds: float
    shift: np.ndarray
    """How far the values moved when four trees took the place of each, (p,); 0 until they do."""
    stages: tuple[FitStage, ...] = ()
    """What each way to look at the targets took."""


class LinearModel(eqx.Module):
    """The residuals near a point."""

    at: Float[Array, "p"]
    residual: Float[Array, "p+1"]
    jacobian: Float[Array, "p+1 p"]

    def __call__(self, x, _):
        return self.residual + self.jacobian @ (x - self.at), None


@dataclass(frozen=True)
class Look:
    """What was found at one point: coefficients, the factor of [J r] there, the rendered targets."""

    x: Float[Array, "p"]
    values: np.ndarray
    factor: np.ndarray
    films: tuple[np.ndarray, ...]

    def linear(self):
        """Coefficients, R, q, and the loss |r|^2 / 2."""
        return self.values, self.factor[:-1, :-1], self.factor[:-1, -1], 0.5 * float(self.factor[:, -1] @ self.factor[:, -1])


def look(problem: Problem, x: Float[Array, "p"], sigma: float) -> Look:
    values = problem.bounds.values(x)
    return Look(x, np.asarray(values, np.float64), *factorise(problem, values, sigma))


def solve(problem: Problem, start: np.ndarray, *, max_steps: int, at_rest: Callable[..., bool] = lambda *a: False,
          on_step: Callable[[FitStep], None] | None = None, loss_scale: float = 1.0, sigma: float = 0.0) -> Solution:
    """From these coefficients until the steps become too small to matter, or `max_steps`, or Ctrl-C.

    `at_rest(values, factor, remainder, loss)` may stop it earlier. `sigma`: blur of the residuals in pixels.
    """
    begun, method = time.perf_counter(), _method(problem.scene.dtype)
    x = problem.bounds.unknowns(jnp.asarray(start, float))
    state = first_state(method, x)
    history, rejected, best = [], 0, None
    with _stop_requests() as stopped:
        for number in range(max_steps):
            here = look(problem, state.y_eval, sigma)
            model = _linear_model(problem, here)
            x, state, done = advance(method, x, state, model)
            accepted = int(state.num_steps_since_acceptance) == 0
            best = here if accepted else best
            history.append(FitStep(number, best.linear()[-1] * loss_scale, time.perf_counter() - begun, accepted))
            if on_step is not None:
                on_step(history[-1])
            rejected = 0 if accepted else rejected + 1
            if bool(done) or rejected >= REJECTIONS or stopped() or at_rest(*best.linear()):
                break
    return Solution(*best.linear(), best.films, tuple(history), stopped(), time.perf_counter() - begun, np.zeros_like(best.values))


def _method(dtype) -> optx.LevenbergMarquardt:
    eps = float(jnp.finfo(dtype).eps)
    method = optx.LevenbergMarquardt(rtol=30 * eps, atol=30 * eps)
    # Near a bound the loss falls by less than the linear model says; the usual cut-off of 0.75 (in place
    # of 0.99) lets the damping shrink there all the same.
    return eqx.tree_at(lambda m: m.search, method, optx.ClassicalTrustRegion(high_cutoff=0.75))


# A Jacobian by "bwd" is an array in the state, where "fwd" would keep a program: the step compiles once for each number of unknowns.
_OPTIONS, _TAGS = {"jac": "bwd"}, frozenset()


@eqx.filter_jit
def first_state(method, x: Float[Array, "p"]):
    """The solver's state before its first step."""
    nothing = LinearModel(x, jnp.zeros(x.size + 1, x.dtype), jnp.zeros((x.size + 1, x.size), x.dtype))
    return method.init(nothing, x, None, _OPTIONS, jax.eval_shape(lambda: nothing.residual), None, _TAGS)


@eqx.filter_jit
def advance(method, x: Float[Array, "p"], state, model: LinearModel):
    """One step with the model at the point that the state asks for: the best point, the new state, and whether it ended."""
    x, state, _ = method.step(model, x, None, _OPTIONS, state, _TAGS)
    return x, state, method.terminate(model, x, None, _OPTIONS, state, _TAGS)[0]


def _linear_model(problem: Problem, here: Look) -> LinearModel:
    jacobian = here.factor[:, :-1] * np.asarray(problem.bounds.slope(here.x), np.float64)
    return LinearModel(here.x, *(jnp.asarray(a, here.x.dtype) for a in (here.factor[:, -1], jacobian)))


@contextmanager
def _stop_requests():
    """While active, the first Ctrl-C asks to stop after the step; the second interrupts at once."""
    asked = []
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    before = signal.getsignal(signal.SIGINT)

    def ask(signum, frame):
        asked.append(True)
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, ask)
    try:
        yield lambda: bool(asked)
    finally:
        signal.signal(signal.SIGINT, before)
