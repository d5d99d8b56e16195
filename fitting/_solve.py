"""Optimistix's Levenberg-Marquardt, one step at a time, so that a person can watch it and stop it."""

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

from ._problem import Problem, compressed
from ._result import FitStep

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
    seconds_compile: float
    seconds_solve: float


class Solver:
    """Levenberg-Marquardt on one problem; compiled once, run from any start."""

    def __init__(self, problem: Problem):
        eps = float(jnp.finfo(problem.scene.dtype).eps)
        self.problem = problem
        method = optx.LevenbergMarquardt(rtol=30 * eps, atol=30 * eps)
        # Near a bound the loss falls by less than the linear model says; the usual cut-off of 0.75 (in place
        # of 0.99) lets the damping shrink there all the same.
        self._method = eqx.tree_at(lambda m: m.search, method, optx.ClassicalTrustRegion(high_cutoff=0.75))
        self._step = None
        self.seconds_compile = 0.0

    def run(self, start: np.ndarray, *, max_steps: int, at_rest: Callable[..., bool] = lambda *a: False, on_step: Callable[[FitStep], None] | None = None,
            loss_scale: float = 1.0) -> Solution:
        """From these coefficients until the steps become too small to matter, or `max_steps`, or Ctrl-C.

        `at_rest(values, factor, remainder, loss)` may stop it earlier.
        """
        x = self.problem.bounds.unknowns(jnp.asarray(start, float))
        state = self._start(x)
        history, rejected, begun = [], 0, time.perf_counter()
        with _stop_requests() as stopped:
            for number in range(max_steps):
                x, state, done, here = self._step(x, state)
                loss = 0.5 * float(np.sum(np.asarray(state.f_info.residual, np.float64) ** 2)) * loss_scale
                accepted = int(state.num_steps_since_acceptance) == 0
                history.append(FitStep(number, loss, time.perf_counter() - begun, accepted))
                if on_step is not None:
                    on_step(history[-1])
                rejected = 0 if accepted else rejected + 1
                linear = _linear_model(here, state)
                if bool(done) or rejected >= REJECTIONS or stopped() or at_rest(*linear):
                    break
        films = tuple(np.asarray(film) for film in state.aux)
        return Solution(*linear, films, tuple(history), stopped(), self.seconds_compile, time.perf_counter() - begun)

    def _start(self, x):
        function, problem = _Residuals(), self.problem
        shape = jax.ShapeDtypeStruct((x.size + 1,), x.dtype)
        films = tuple(jax.ShapeDtypeStruct(view.target.shape, view.target.dtype) for view in problem.views)
        state = self._method.init(function, x, problem, {}, shape, films, frozenset())
        if self._step is None:
            begun = time.perf_counter()
            dynamic, static = eqx.partition(state, eqx.is_array)

            @eqx.filter_jit
            def step(x, dynamic, problem):
                state = eqx.combine(dynamic, static)
                x, state, _ = self._method.step(function, x, problem, {}, state, frozenset())
                done, _ = self._method.terminate(function, x, problem, {}, state, frozenset())
                here = (problem.bounds.values(x), problem.bounds.slope(x), state.f_info.jac.as_matrix())
                return x, eqx.filter(state, eqx.is_array), done, here

            compiled = step.lower(x, dynamic, problem).compile()

            def run(x, state):
                x, dynamic, done, here = compiled(x, eqx.filter(state, eqx.is_array), self.problem)
                return x, eqx.combine(dynamic, static), done, here

            self._step = run
            self.seconds_compile = time.perf_counter() - begun
        return state


def _linear_model(here, state):
    """Coefficients, R in the coefficients, q, and the loss, at the last accepted step."""
    values, slope, jacobian = (np.asarray(a, np.float64) for a in here)
    residual = np.asarray(state.f_info.residual, np.float64)
    factor = np.divide(jacobian[:-1], slope, out=np.zeros_like(jacobian[:-1]), where=slope != 0)
    return values, factor, residual[:-1], 0.5 * float(residual @ residual)


class _Residuals(eqx.Module):
    """The function that optimistix sees: compressed residuals, with the films beside them."""

    def __call__(self, x, problem: Problem):
        return compressed(x, problem)


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
