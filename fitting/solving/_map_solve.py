"""Least squares for the texels of a map: Gauss and Newton's steps, and what the pictures say of each texel.

The normal equations of a step are solved channel by channel through the factor of a sparse matrix. Where some pixels'
rows are not known (`judging._map_rows`), the matrix is that of the others, and stands as preconditioner in conjugate
gradients whose products go through the recorded trees, forward and backward.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from ..judging._banded import Banded
from ..judging._map_rows import WAYS, MapRows, map_rows
from ..problem._map_view import MapView

DAMPING = 1e-6
"""Share of the median diagonal entry that is added in a step: what is hardly seen moves little."""
STILL = 1e-6
"""A step whose mean square is a smaller share of the largest texel's is none, root for root."""
SETTLED = 0.01
"""Nor is one of a smaller part of the standard errors, in the mean over the texels."""
CURVED = 1e-3
"""The rows are asked for anew where a step changed the pictures otherwise than they said, by more than this share of
what is left over."""
LEAST = 1e-8
"""A texel with a smaller share of the largest diagonal entry is not seen."""
MOST_PRODUCTS = 200
CLOSE = 1e-6
Texels = Float[np.ndarray, "height width 3"]


@dataclass(frozen=True, eq=False)
class MapSolution:
    """Where the steps came to an end."""

    texels: Texels
    pictures: list[np.ndarray]
    rows: list[MapRows]
    """Of each picture, at the end."""
    steps: int
    converged: bool


def solve_map(
    views: Sequence[MapView], texels: Texels, max_steps: int, on_step: Callable[[int, float], None]
) -> MapSolution:
    """Steps from `texels` until they are small; `on_step` is told of each, with the root mean square of the weighted
    residuals.
    """
    dtype = views[0].parts[0].scene.dtype
    rows, factors, converged = None, None, False
    # Compile both programs at once.
    with ThreadPoolExecutor(1) as aside:
        compiling = aside.submit(views[0].compile_along, texels.astype(dtype), WAYS)
        pictures = [view.picture(texels.astype(dtype)) for view in views]
        compiling.result()
    step_count = 0
    for step_count in range(max_steps + 1):
        loss = _loss(views, pictures)
        on_step(step_count, loss)
        if rows is None:
            rows = [map_rows(view, texels.astype(dtype)) for view in views]
            factors = _factors(views, rows)
        step, gain = _step(views, rows, factors, texels.astype(dtype), pictures)
        small = np.sqrt(np.mean(step**2)) <= STILL * max(abs(texels).max(), 1e-3)
        if small or gain <= SETTLED**2 * loss**2 * texels.size:
            converged = True
            break
        if step_count == max_steps:
            break
        # Go as far as it helps.
        for share in (1.0, 0.5, 0.25, 0.125):
            new = texels + share * step
            after = [view.picture(new.astype(dtype)) for view in views]
            if _loss(views, after) < loss:
                break
        else:
            # What is left is rounding.
            converged = True
            break
        if _surprise(views, rows, share * step, pictures, after) > CURVED * loss:
            rows = None
        texels, pictures = new, after
    rows = rows or [map_rows(view, texels.astype(dtype)) for view in views]
    return MapSolution(texels, pictures, rows, step_count, converged)


def normal_matrix(views: Sequence[MapView], rows: Sequence[MapRows], channel: int) -> sparse.csr_array:
    """J' W J of the rows that are known."""
    total = 0
    for view, mine in zip(views, rows, strict=True):
        weighted = sparse.diags_array(view.weight[..., channel].ravel()) @ mine.channels[channel]
        total = total + weighted.T @ weighted
    return sparse.csr_array(total)


def sighted(normal: sparse.csr_array) -> Bool[np.ndarray, "texels"]:
    """The texels that any pixel sees."""
    diagonal = normal.diagonal()
    return diagonal > LEAST * max(diagonal.max(initial=0), 1e-300)


def _factors(views, rows) -> list[tuple[np.ndarray, Banded | None]]:
    """For each channel the texels that are seen, and the factor of their damped normal matrix."""
    found = []
    for channel in range(3):
        normal = normal_matrix(views, rows, channel)
        seen = np.flatnonzero(sighted(normal))
        part = normal[seen][:, seen]
        damping = DAMPING * np.median(part.diagonal()) if seen.size else 0
        found.append((seen, Banded.of(part + damping * sparse.eye_array(seen.size)) if seen.size else None))
    return found


def _step(views, rows, factors, texels, pictures) -> tuple[Texels, float]:
    """The solution of the normal equations, and what it takes off the sum of squares."""
    wanted = [view.weight**2 * (view.target - shown) for view, shown in zip(views, pictures, strict=True)]
    whole = all(mine.known[view.weight.any(axis=-1)].all() for view, mine in zip(views, rows, strict=True))
    if whole:
        pairs = list(zip(rows, wanted, strict=True))
        gradient = np.stack(
            [sum(m.channels[c].T @ w[..., c].ravel() for m, w in pairs) for c in range(3)], axis=-1
        ).reshape(texels.shape)
        step = _preconditioned(factors, gradient)
        return step, float((gradient * step).sum())
    zero = np.zeros(texels.shape)
    gradient = sum((view.back(texels, w) for view, w in zip(views, wanted, strict=True)), start=zero)

    def product(way: Texels) -> Texels:
        ways = way[None].astype(texels.dtype)
        looks = (view.back(texels, view.weight**2 * view.along(texels, ways)[0]) for view in views)
        return sum(looks, start=zero)

    step = _conjugate_gradients(product, lambda g: _preconditioned(factors, g), gradient)
    return step, float((gradient * step).sum())


def _preconditioned(factors, gradient: Texels) -> Texels:
    """The step by the factors; none of texels that are not seen."""
    flat, step = gradient.reshape(-1, 3), np.zeros((gradient[..., 0].size, 3))
    for channel, (seen, factor) in enumerate(factors):
        if factor is not None:
            step[seen, channel] = factor.solve(flat[seen, channel])
    return step.reshape(gradient.shape)


def _conjugate_gradients(product: Callable, preconditioned: Callable, right: Texels) -> Texels:
    """Hestenes and Stiefel (1952), with a preconditioner; as far as it comes in so many products."""

    def of_texels(fun: Callable) -> LinearOperator:
        flat = (right.size, right.size)
        return LinearOperator(flat, matvec=lambda way: fun(way.reshape(right.shape)).ravel(), dtype=right.dtype)  # pyright: ignore[reportCallIssue]

    found, _ = cg(of_texels(product), right.ravel(), rtol=CLOSE, maxiter=MOST_PRODUCTS, M=of_texels(preconditioned))
    return found.reshape(right.shape)


def _loss(views, pictures) -> float:
    """The root mean square of the weighted residuals."""
    squares = [(v.weight * (v.target - p)) ** 2 for v, p in zip(views, pictures, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate([s[v.weight > 0] for s, v in zip(squares, views, strict=True)]))))


def _surprise(views, rows, step: Texels, before, after) -> float:
    """By how much the pictures changed otherwise than the rows say, weighted as residuals are."""
    apart = []
    for view, mine, old, new in zip(views, rows, before, after, strict=True):
        said = np.stack([mine.channels[c] @ step[..., c].ravel() for c in range(3)], axis=-1).reshape(old.shape)
        apart.append((view.weight * (new - old - said))[mine.known].ravel())
    return float(np.sqrt(np.mean(np.concatenate(apart) ** 2)))
