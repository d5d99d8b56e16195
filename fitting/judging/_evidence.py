"""What each pixel says of each coefficient, and from there standard errors that hold where residuals are no white
noise.

At the solution the scores g_i = sum over the channels of J_i r_i (weighted) of all pixels i add up to nothing. If
residuals were independent with the assumed variance, the covariance would be that of the linear model, A^-1 with A =
J'J. In general it is the sandwich A^-1 B A^-1 with B = sum over groups G of (sum of g_i in G)(...)', where what is in
one group may be correlated in any way and groups are independent (Huber 1967; White 1980; for groups Liang and Zeger
1986). A wrong model spreads over whole objects: there, leaving out one contiguous piece of the objects after another
(delete-a-group jackknife) tells how far the answer hangs on the piece.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..problem._problem import Problem
from ..problem._target import CheckedTarget
from ..problem._whole_pictures import whole_rows
from ._normal import normal_inverse

BLOCKS = (8, 16, 32)
"""Sides of square groups of pixels."""
LARGE, TOGETHER = 6.0, (2, 3, 4)
"""Where an error by pieces is so many times that of independent residuals, pieces are left out up to four at a time
too.
"""
MOST_LOST = 2.0
"""A piece without which the variance of a coefficient is more times what it was counts as if it were so many times."""
SECTORS = 12
"""Pieces into which the pixels of a target are parted, around the middle of what its coefficients see."""


@dataclass(frozen=True)
class Evidence:
    """Scores and normal matrices at the solution, in units of the weighted residuals."""

    scores: tuple[np.ndarray, ...]
    """For each target (height, width, p)."""
    pieces: tuple[np.ndarray, ...]
    """For each target the number of the piece of each pixel."""
    grams: np.ndarray
    """(pieces, p, p): J'J of each piece."""
    prior: np.ndarray
    """(p, p): J'J of the priors."""
    noise: float
    """Standard deviation of the residuals, beside which the priors are weighed."""

    @property
    def gram(self) -> np.ndarray:
        return self.grams.sum(axis=0) + self.prior


def evidence(problem: Problem, targets: Sequence[CheckedTarget], values: np.ndarray, noise: float) -> Evidence:
    """At these coefficients, one look at all pixels."""
    count, first = len(problem.unknowns), 0
    scores, pieces, grams = [], [], []
    for rows, target in zip(whole_rows(problem, values), targets, strict=True):
        jacobian, numbers = rows.columns, rows.numbers
        score = np.moveaxis((jacobian * rows.residual).sum(axis=-1), -1, 0).astype(np.float64)
        piece = _sectors(np.abs(jacobian).sum(axis=(2, 3)) * (target.mask > 0))
        gram = np.zeros((SECTORS, count, count))
        for number in range(SECTORS):
            part = jacobian[piece == number].transpose(1, 0, 2).reshape(len(numbers), -1).astype(np.float64)
            part = problem.joined(part, numbers)
            gram[number] = part @ part.T
        scores.append(np.moveaxis(problem.joined(score, numbers), 0, -1))
        pieces.append(piece + first)
        grams.append(gram)
        first += SECTORS
    prior = np.zeros((count, count)) if problem.priors is None else np.diag(problem.priors.weight**2)
    return Evidence(tuple(scores), tuple(pieces), np.concatenate(grams), prior, noise)


def scatter(
    problem: Problem, targets: Sequence[CheckedTarget], values: np.ndarray, departures: Sequence[np.ndarray]
) -> np.ndarray:
    """The covariance of the coefficients, (p, p), if the targets departed from what is fitted as in these examples,
    (examples, height, width, 3) for each target.
    """
    count = len(problem.unknowns)
    gram, scores = np.zeros((count, count)), np.zeros((len(departures[0]), count))
    for rows, target, examples in zip(whole_rows(problem, values), targets, departures, strict=True):
        jacobian = np.moveaxis(rows.columns, 2, 0).astype(np.float64)
        jacobian = problem.joined(jacobian, rows.numbers).reshape(count, -1)
        weighed = examples * np.asarray(rows.view.weight) * (target.mask > 0)[..., None]
        gram += jacobian @ jacobian.T
        scores += weighed.reshape(len(weighed), -1) @ jacobian.T
    if problem.priors is not None:
        gram += np.diag(problem.priors.weight**2)
    changes = scores @ normal_inverse(gram, 1e-9)
    return changes.T @ changes / len(changes)


def narrowed(found: Evidence, ways: np.ndarray) -> Evidence:
    """What it says of the ways (p, m) along which coefficients move together."""
    scores = tuple(score @ ways for score in found.scores)
    return replace(found, scores=scores, grams=ways.T @ found.grams @ ways, prior=ways.T @ found.prior @ ways)


def robust_errors(found: Evidence, correlated: bool) -> dict[str, np.ndarray]:
    """Standard errors (p,) by what they allow for: residuals of any size, residuals that go along with their
    neighbours', a model that is wrong over whole objects.
    """
    inverse = normal_inverse(found.gram, 1e-9)

    def error(covariance: np.ndarray) -> np.ndarray:
        return np.sqrt(np.maximum(np.diagonal(covariance), 0))

    errors = {"sizes": error(inverse @ sandwich(found, 1) @ inverse)}
    if correlated:
        errors |= {f"blocks of {side}": error(inverse @ sandwich(found, side) @ inverse) for side in BLOCKS}
        errors["pieces"] = error(jackknife(found))
        # What is wrong in so large a way is wrong over larger pieces too.
        # Where residuals are below the least that arithmetic leaves, that is what independent ones count.
        independent = np.maximum(errors["sizes"], found.noise * error(inverse))
        with np.errstate(all="ignore"):
            ratio = np.nanmax(errors["pieces"] / independent, initial=0)
        if ratio > LARGE:
            errors |= {f"{n} pieces as one": error(jackknife(found, n)) for n in TOGETHER}
    return errors


def _sectors(size: np.ndarray) -> np.ndarray:
    """The number of the sector of each pixel, around the middle of where `size` is; as many pixels that count in
    each.
    """
    down, across = np.indices(size.shape)
    total = max(float(size.sum()), 1e-300)
    middle = (down * size).sum() / total, (across * size).sum() / total
    angle = np.arctan2(down - middle[0], across - middle[1])
    counted = np.sort(angle[size > 0]) if (size > 0).any() else np.zeros(1)
    ends = counted[np.linspace(0, len(counted) - 1, SECTORS + 1).astype(int)[1:-1]]
    return np.searchsorted(ends, angle, side="right")


def sandwich(found: Evidence, side: int) -> np.ndarray:
    """B of groups that are squares of so many pixels, (p, p); groups that say nothing do not count."""
    total, groups = np.zeros_like(found.gram), 0
    for score in found.scores:
        height, width, count = score.shape
        room = ((0, -height % side), (0, -width % side), (0, 0))
        blocks = np.pad(score, room).reshape(-(-height // side), side, -(-width // side), side, count).sum(axis=(1, 3))
        flat = blocks.reshape(-1, count)
        flat = flat[np.any(flat != 0, axis=1)]
        total, groups = total + flat.T @ flat, groups + len(flat)
    return total * groups / max(groups - len(found.gram), 1) + found.prior * found.noise**2


def jackknife(found: Evidence, together: int = 1) -> np.ndarray:
    """The covariance, (p, p), by leaving out one piece after another: (n - 1)/n times the sum of squares of what that
    changes. `together`: so many neighbouring pieces are one.
    """
    grams = found.grams.reshape(-1, together, *found.gram.shape).sum(axis=1)
    scores = np.zeros((len(grams), len(found.gram)))
    for score, piece in zip(found.scores, found.pieces, strict=True):
        np.add.at(scores, piece.ravel() // together, score.reshape(-1, score.shape[-1]))
    whole, changes = np.diagonal(normal_inverse(found.gram, 1e-7)), []
    for gram, score in zip(grams, scores, strict=True):
        rest = normal_inverse(found.gram - gram, 1e-7, like=found.gram)
        # What hardly anything but this piece tells of changes by its noise alone: count no more than twice that.
        lost = np.divide(np.diagonal(rest), whole, out=np.ones_like(whole), where=whole > 0)
        changes.append(rest @ score * np.minimum(1, (MOST_LOST / np.maximum(lost, 1e-300)) ** 0.5))
    used = np.array([bool(np.any(gram)) for gram in grams])
    spread = np.stack(changes)[used]
    spread = spread - spread.mean(axis=0)
    return (len(spread) - 1) / max(len(spread), 1) * spread.T @ spread
