"""How well a fit predicts the pixels that it did not look at."""

from collections.abc import Sequence
from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from diffwhitted.scene import Scene

from ._held_out import HeldOut
from ._result import FitResult, FitView
from .judging._misfit import at_rounding
from .judging._rest import rest_share


def with_prediction(result: FitResult, left_out: Sequence[np.ndarray], what: str, scene: Scene) -> FitResult:
    """The result with what it says of the pixels left out, (height, width) of each view. A view that was left out as a
    whole gets its own residual, and its pixels' weight.
    """
    pairs = list(zip(result.views, left_out, strict=True))
    apart = [_residual(view, out) for view, out in pairs]
    missed = np.concatenate([residual[out] for residual, (_, out) in zip(apart, pairs, strict=True)])
    shown = np.concatenate([view.target[out] for view, out in pairs])
    fitted = np.concatenate([view.residual[view.weight > 0] for view in result.views])
    held = HeldOut(
        what,
        sum(int(out.sum()) for out in left_out),
        _root_mean_square(missed),
        _root_mean_square(fitted),
        bool(at_rounding(missed, shown, float(jnp.finfo(scene.dtype).eps), rest_share(scene))),
        tuple(view.camera for view, out in pairs if out.any() and not view.weight.any()),
    )
    views = tuple(
        replace(view, residual=residual, weight=out.astype(np.float32)) if out.any() and not view.weight.any() else view
        for residual, (view, out) in zip(apart, pairs, strict=True)
    )
    return replace(result, held_out=held, views=views, message=f"{result.message}; {held.sentence}")


def _residual(view: FitView, there: np.ndarray) -> np.ndarray:
    """What is left over where `there`, 0 elsewhere."""
    return np.where(there[..., None], view.render - view.target, 0).astype(np.float32)


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64)))) if values.size else 0.0
