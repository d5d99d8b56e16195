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

from diffwhitted.numerics._kept import kept

from .._result import FitStage, FitStep
from ..judging._rest import ON_THE_BOUND, next_step
from ..problem._problem import Problem, factorise

REJECTIONS = 8
"""So many rejected steps in a row mean that the loss cannot fall any further in this precision."""
UNSEEN = 8.0
"""A step that promises to lower the loss by fewer units in its last place cannot be judged by the loss."""


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
    boldness: float
    """1 / lambda of Levenberg and Marquardt at the end."""
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
        return (
            self.values,
            self.factor[:-1, :-1],
            self.factor[:-1, -1],
            0.5 * float(self.factor[:, -1] @ self.factor[:, -1]),
        )


def look(problem: Problem, x: Float[Array, "p"], sigma: float) -> Look:
    values = problem.bounds.values(x)
    return Look(x, np.asarray(values, np.float64), *factorise(problem, values, sigma))


def solve(
    problem: Problem,
    start: np.ndarray,
    *,
    max_steps: int,
    at_rest: Callable[..., bool] = lambda *a: False,
    on_step: Callable[[FitStep], None] | None = None,
    loss_scale: float = 1.0,
    sigma: float = 0.0,
    boldness: float | None = None,
) -> Solution:
    """From these coefficients until the steps become too small to matter, or `max_steps`, or Ctrl-C.

    `at_rest(values, factor, remainder, loss)` may stop it earlier. `sigma`: blur of the residuals in pixels. Where
    the solver rejects a step that is too small to be seen in the loss, the next ones are Gauss-Newton steps, each of
    which must promise less than the one before. `boldness`: that of a run before, to go on with.
    """
    begun, method = time.perf_counter(), _method(problem.scene.dtype)
    x = problem.bounds.unknowns(jnp.asarray(start, float))
    state = _bold(first_state(method, x), boldness)
    history: list[FitStep] = []
    rejected, best = 0, None

    def note(here: Look, accepted: bool, best: Look | None) -> Look:
        """The better of the two; in the history is always the loss of the better one."""
        better = here if accepted or best is None else best
        history.append(FitStep(len(history), better.linear()[-1] * loss_scale, time.perf_counter() - begun, accepted))
        if on_step is not None:
            on_step(history[-1])
        return better

    with _stop_requests() as stopped:
        while len(history) < max_steps:
            here = look(problem, state.y_eval, sigma)
            x, state, done = advance(method, x, state, _linear_model(problem, here))
            accepted = int(state.num_steps_since_acceptance) == 0
            best = note(here, accepted, best)
            rejected = 0 if accepted else rejected + 1
            if (
                bool(done)
                or rejected >= REJECTIONS
                or stopped()
                or at_rest(*best.linear())
                or (rejected and _is_unseen(problem, best))
            ):
                break
        assert best is not None, "max_steps is 1 or more"
        while len(history) < max_steps and _is_unseen(problem, best) and not (stopped() or at_rest(*best.linear())):
            step, promise = _promise(problem, best)
            low, high = np.asarray([u.bounds for u in problem.unknowns], np.float64).T
            here = look(
                problem, problem.bounds.unknowns(jnp.asarray(np.clip(best.values + step, low, high), float)), sigma
            )
            better = _promise(problem, here)[1] < promise
            best = note(here, better, best)
            if not better:
                break
    return Solution(
        *best.linear(),
        best.films,
        tuple(history),
        stopped(),
        time.perf_counter() - begun,
        float(_boldness(state)),
        np.zeros_like(best.values),
    )


def compile_solver(problem: Problem, start: np.ndarray) -> None:
    """Compile what `solve` needs beside the residuals, which is kept."""
    method, x = _method(problem.scene.dtype), problem.bounds.unknowns(jnp.asarray(start, float))
    advance(method, x, _bold(first_state(method, x), None), _flat(x))


def _boldness(state):
    return state.search_state.step_size


def _bold(state, boldness: float | None):
    """The state with that boldness, or its own; in either case as a number of one type, for which the step is
    compiled once.
    """
    own = _boldness(state)
    return eqx.tree_at(_boldness, state, jnp.asarray(float(own) if boldness is None else boldness, own.dtype))


def _promise(problem: Problem, here: Look) -> tuple[np.ndarray, float]:
    """The next Gauss-Newton step, and by how much the linear model says that it lowers the loss."""
    values, factor, remainder, _ = here.linear()
    low, high = np.asarray([u.bounds for u in problem.unknowns], np.float64).T
    seen, precision = np.linalg.norm(factor, axis=0) > 0, float(jnp.finfo(problem.scene.dtype).eps) ** 0.7
    step = next_step(values, factor, remainder, seen, ON_THE_BOUND * (high - low), problem.unknowns, precision)
    return step, 0.5 * float(np.sum((factor @ step) ** 2))


def _is_unseen(problem: Problem, here: Look) -> bool:
    """Is the next step too small for the loss to tell whether it is one for the better?"""
    return _promise(problem, here)[1] < UNSEEN * float(jnp.finfo(problem.scene.dtype).eps) * here.linear()[-1]


def _method(dtype) -> optx.LevenbergMarquardt:
    eps = float(jnp.finfo(dtype).eps)
    method = optx.LevenbergMarquardt(rtol=30 * eps, atol=30 * eps)
    # Near a bound the loss falls by less than the linear model says; the usual cut-off of 0.75 (in place
    # of 0.99) lets the damping shrink there all the same.
    return eqx.tree_at(lambda m: m.search, method, optx.ClassicalTrustRegion(high_cutoff=0.75))


# A Jacobian by "bwd" is an array in the state, where "fwd" would keep a program: the step compiles once for each
# number of unknowns.
_OPTIONS, _TAGS = {"jac": "bwd"}, frozenset()


@kept
def first_state(method, x: Float[Array, "p"]):
    """The solver's state before its first step."""
    nothing = _flat(x)
    return method.init(nothing, x, None, _OPTIONS, jax.eval_shape(lambda: nothing.residual), None, _TAGS)


@kept
def advance(method, x: Float[Array, "p"], state, model: LinearModel):
    """One step with the model at the point that the state asks for: the best point, the new state, and whether it
    ended.
    """
    x, state, _ = method.step(model, x, None, _OPTIONS, state, _TAGS)
    return x, state, method.terminate(model, x, None, _OPTIONS, state, _TAGS)[0]


def _flat(x: Float[Array, "p"]) -> LinearModel:
    """A model of the right shapes."""
    return LinearModel(x, jnp.zeros(x.size + 1, x.dtype), jnp.zeros((x.size + 1, x.size), x.dtype))


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
