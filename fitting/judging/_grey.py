"""Were numbers sought as grey that the pictures show in colour?

At the solution the channels' scores of a grey number cancel in the sum. What each channel alone would change it by, the
Gauss-Newton step of that channel's rows, says whether they agree.
"""

from collections.abc import Sequence

import numpy as np

from diffwhitted.scene import Scene

from ..problem._colour import is_grey
from ..problem._problem import Problem, pass_rows
from ..problem._target import CheckedTarget
from ._normal import normal_inverse

CLEARLY = 6.0
"""Standard errors between two channels that do not agree."""
MATTERS = 0.02
"""Share of the number below which it does not matter, and of 1 for a number near 0."""


def grey_only(scene: Scene, problem: Problem, targets: Sequence[CheckedTarget], values: np.ndarray) -> tuple[str, ...]:
    """The names of the free numbers that are one in the scene, where the channels of the targets ask for several."""
    grey = [i for i, u in enumerate(problem.unknowns) if not u.component and is_grey(scene, u.parameter)]
    if not grey or all(t.monochrome for t in targets):
        return ()
    count = len(problem.unknowns)
    gram, score, left = np.zeros((3, count, count)), np.zeros((3, count)), 0.0
    asked = problem.asked(values)
    for view in problem.views:
        names = asked.columns_of(view.parts[0])
        for rows, _ in pass_rows(asked, view, np.asarray):
            whole = problem.joined(rows[:-1].astype(np.float64), names)
            residual = rows[-1].astype(np.float64)
            gram += np.einsum("icp,jcp->cij", whole, whole)
            score += np.einsum("icp,cp->ci", whole, residual)
            left += float((residual**2).sum())
    noise = (left / max(sum(3 * int((t.mask > 0).sum()) for t in targets) - count, 1)) ** 0.5
    steps, errors = np.zeros((3, count)), np.zeros((3, count))
    for channel in range(3):
        inverse = normal_inverse(gram[channel], 1e-6)
        steps[channel] = -inverse @ score[channel]
        errors[channel] = noise * np.sqrt(np.maximum(np.diagonal(inverse), 0))
    apart, error = np.ptp(steps, axis=0), np.sqrt((errors**2).sum(axis=0))
    matters = MATTERS * np.maximum(abs(values), MATTERS)
    return tuple(problem.unknowns[i].name for i in grey if apart[i] > max(CLEARLY * error[i], matters[i]))


def grey_note(names: Sequence[str]) -> tuple[str, ...]:
    """What to say of them."""
    if not names:
        return ()
    verb = "was sought as one grey number" if len(names) == 1 else "were sought as grey numbers"
    return (
        f"{', '.join(names)} {verb}, but the target is coloured there; let a channel each be free with colour "
        f"(--colour {' '.join(names)})",
    )
