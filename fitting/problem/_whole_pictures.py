"""Whole pictures, put together from their passes: what a solution shows, and what each pixel says of the unknowns."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from diffwhitted.image import gathered

from ._problem import Problem, pass_rows
from ._target import CheckedTarget
from ._views import View


class WholeRows(NamedTuple):
    """The rows [J r] of one target at some coefficients, weighted as in the fit."""

    view: View
    columns: Float[np.ndarray, "height width m 3"]
    numbers: list[int]
    """Of the unknowns to which the columns belong (see `Problem.joined`)."""
    residual: Float[np.ndarray, "height width 1 3"]
    shown: Float[np.ndarray, "height width 3"]
    """What the shot shows, float64."""


def whole_rows(problem: Problem, values: np.ndarray) -> Iterator[WholeRows]:
    """Target by target, whose rows fit the memory one at a time."""
    asked = problem.asked(values)
    for view in problem.views:
        names = asked.columns_of(view.parts[0])
        mine = [k for k, name in enumerate(names) if name >= 0]
        passes = list(pass_rows(asked, view, np.asarray))
        rows = np.stack([rows.reshape(-1, rows.shape[-1]) for rows, _ in passes])
        picture = np.asarray(view.picture(rows)).reshape(*view.weight.shape[:2], -1, 3)
        shown = np.asarray(view.picture(np.stack([seen for _, seen in passes])), np.float64)
        yield WholeRows(view, picture[:, :, mine], [names[k] for k in mine], picture[:, :, -1:], shown)


def shown_by(targets: Sequence[CheckedTarget], films: Iterable[np.ndarray]) -> list[np.ndarray]:
    """The pictures of films as passes have them, (height, width, 3), float64."""
    return [np.asarray(gathered(film, *t.mask.shape), np.float64) for t, film in zip(targets, films, strict=True)]


def of_used(targets: Sequence[CheckedTarget], pictures: Iterable[np.ndarray]) -> np.ndarray:
    """The channels of all pixels that count, one after another, of pictures (height, width, 3)."""
    return np.concatenate([picture[t.mask > 0].ravel() for t, picture in zip(targets, pictures, strict=True)])


def brightness(targets: Sequence[CheckedTarget]) -> float:
    """That of the brighter pixels: the 99th percentile of the values that count, of the target where it is largest."""
    used = [np.abs(t.image[t.mask > 0]) for t in targets]
    return max(float(np.percentile(values, 99)) for values in used if values.size)
