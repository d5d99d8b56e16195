"""Highlights smaller than a pixel: how sharp they are no picture tells."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .._result import FitResult, FittedCoefficient
from ..problem._problem import Problem, pass_rows

SHARP = 300.0
"""Exponents below this have highlights of several degrees."""
PIXELS = 2.5
"""An exponent that rests on no more pixels than so many is told by where its highlight happens to lie in them."""


def too_sharp(problem: Problem, values: np.ndarray) -> tuple[str, ...]:
    """The exponents whose highlights are smaller than a pixel.

    Their number of pixels is (sum J^2)^2 / sum J^4 over the pixels that depend on the exponent.
    """
    chosen = [i for i, u in enumerate(problem.unknowns) if u.row.name == "phong_exponent" and values[i] > SHARP]
    if not chosen:
        return ()
    squares, fourth, asked = np.zeros(len(chosen)), np.zeros(len(chosen)), problem.asked(values)
    for view in problem.views:
        names = asked.columns_of(view.parts[0])
        for rows, _ in pass_rows(asked, view, np.asarray):
            column = problem.joined(rows[:-1].astype(np.float64), names)[chosen]
            size = (column**2).sum(axis=1)
            squares, fourth = squares + size.sum(axis=1), fourth + (size**2).sum(axis=1)
    pixels = np.divide(squares**2, fourth, out=np.full(len(chosen), np.inf), where=fourth > 0)
    return tuple(problem.unknowns[i].name for i, count in zip(chosen, pixels, strict=True) if count < PIXELS)


def without_sharp(result: FitResult, names: Sequence[str]) -> FitResult:
    """The result, where these exponents are not determined, nor how much their highlights send back."""
    if not names or result.status in ("interrupted", "not_converged"):
        return result
    said = "its highlight is smaller than a pixel, so the picture does not tell how sharp it is"
    owners = {name.rpartition(".")[0] for name in names}

    def told(c: FittedCoefficient) -> FittedCoefficient:
        owner, _, what = c.name.partition(".")
        if c.name not in names and not (owner in owners and what.partition(".")[0] == "k_h"):
            return c
        return replace(c, identifiable=False, standard_error=None, interval_95=None, further=(*c.further, said))

    coefficients = tuple(map(told, result.coefficients))
    message = f"the pictures do not determine {', '.join(names)}: the highlight is smaller than a pixel"
    _, _, rest = result.message.partition("; ")
    first = result.message.partition("; ")[0] if result.status == "not_identifiable" else ""
    return replace(
        result,
        status="not_identifiable",
        coefficients=coefficients,
        message="; ".join(filter(None, (first, message, rest))),
    )
