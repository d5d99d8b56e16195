"""What planned pictures say of the unknowns, at the values of the scene."""

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from diffwhitted.image import gathered

from ..judging._identifiability import Uncertainty, uncertainty
from ..judging._rest import jacobian_precision
from ..problem._problem import Problem, factorise
from ..problem._rows import record_part
from ..problem._target import CheckedTarget, residual_count
from ..problem._views import Part
from ..problem._weighing import first_weighing, weighed

RESOLVED = 4.0
"""No standard error is below so many units in the last place of the coefficient."""


@dataclass(frozen=True)
class Looked:
    """R of the residuals' Jacobian in units of the noise, (p, p), and what is known by it."""

    factor: np.ndarray
    known: Uncertainty


def factor_at(
    problem: Problem, targets: tuple[CheckedTarget, ...], values: np.ndarray
) -> tuple[np.ndarray, tuple[CheckedTarget, ...]]:
    """R in units of the noise, and the targets with what they would show. Noise of light is that of this light."""
    total = float(residual_count(targets))
    factor, films = factorise(problem, values)
    shown = tuple(
        replace(t, image=np.asarray(gathered(film, *t.image.shape[:2]), np.float64))
        for t, film in zip(targets, films, strict=True)
    )
    if any(t.noise is not None and t.noise.gain for t in targets):
        factor = factorise(weighed(problem, shown, first_weighing(shown, total)), values)[0]
    # Residuals are divided by the root of their number; R is in the columns of the unknowns alone.
    return factor[:-1, :-1] * np.sqrt(total), shown


def known_by(problem: Problem, factor: np.ndarray, values: np.ndarray) -> Uncertainty:
    """What a factor in units of the noise says."""
    eps = float(jnp.finfo(problem.scene.dtype).eps)
    return uncertainty(factor, 1.0, values, problem.unknowns, jacobian_precision(problem.scene), RESOLVED * eps)


def together(*factors: np.ndarray) -> np.ndarray:
    """The factor of several pictures from that of each."""
    return np.asarray(np.linalg.qr(np.concatenate(factors), mode="r"))


def retraced(problem: Problem, values: np.ndarray) -> Problem:
    """The problem with the trees of its scene as it is now, with no other program unless they need more room. Where
    rays move they are traced anew at each look, and nothing is to be done."""
    if problem.moves:
        return problem
    asked = problem.asked(values)

    def traced(part: Part) -> Part:
        while True:
            trees = record_part(asked.scene, asked.unknowns, asked.values, replace(part, trees=None))
            needed = int(trees.descendants.max())
            if needed <= part.plan.capacity:
                return replace(part, trees=trees)
            part = replace(part, plan=part.plan.with_capacity(2 * needed))

    return replace(problem, views=tuple(replace(v, parts=tuple(map(traced, v.parts))) for v in problem.views))
