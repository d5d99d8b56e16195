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
from ..judging._active import within
from ..problem._problem import Problem, factorise
from ._along_bounds import is_held, is_stuck, promise, shares

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
    prior_loss: float

    @property
    def loss(self) -> float:
        """|r|^2 / 2 with that of priors."""
        return 0.5 * float(self.factor[:, -1] @ self.factor[:, -1])

    def linear(self):
        """Coefficients, R, q, and the loss of the pictures alone."""
        return self.values, self.factor[:-1, :-1], self.factor[:-1, -1], self.loss - self.prior_loss


def look(problem: Problem, x: Float[Array, "p"], sigma: float) -> Look:
    return look_at(problem, np.asarray(problem.bounds.values(x), np.float64), sigma, x)


def look_at(problem: Problem, values: np.ndarray, sigma: float, x: Float[Array, "p"] | None = None) -> Look:
    """At coefficients themselves, which may lie on their bounds; `x`: the solver's unknowns there."""
    x = jnp.asarray(values, float) if x is None else x
    return Look(x, values, *factorise(problem, values, sigma), problem.prior_loss(values))


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
                or is_stuck(history, problem, best)
            ):
                break
        assert best is not None, "max_steps is 1 or more"
        before = None
        while len(history) < max_steps and not (stopped() or at_rest(*best.linear())):
            unseen = _is_unseen(problem, best)
            if not (unseen or is_held(problem, best)):
                break
            step, promised = promise(problem, best)
            better = False
            for share in (1.0,) if unseen else shares(before, step):
                here = look_at(problem, within(best.values, share * step, problem.unknowns), sigma)
                better = promise(problem, here)[1] < promised if unseen else here.loss < best.loss
                best = note(here, better, best)
                if better or len(history) >= max_steps:
                    break
            before = step
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


def _is_unseen(problem: Problem, here: Look) -> bool:
    """Is the next step too small for the loss to tell whether it is one for the better?"""
    return promise(problem, here)[1] < UNSEEN * float(jnp.finfo(problem.scene.dtype).eps) * here.loss


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
    jacobian = problem.bounds.in_unknowns(here.factor[:, :-1], here.x)
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
