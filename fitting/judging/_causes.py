"""What may be wrong where a model does not fit: likely mistakes, each tried out, and how much of the residual it
explains.

Mistakes in the picture (its curve, a flip, a shift, a factor) are tried on the target, with the linear step that each
allows. Mistakes in the scene (the other highlight, the other shadows) need another program, and a few steps.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diffwhitted.image import decode_signal, encode_signal
from diffwhitted.records import changed
from diffwhitted.scene import Scene

from ..problem._problem import Problem
from ..problem._target import CheckedTarget
from ..problem._whole_pictures import whole_rows
from ._normal import normal_inverse

WORTH = 0.3
"""A cause is named where it would remove at least this share of what is left over."""
ENOUGH = 0.6
"""Where a mistake in the picture explains so much, none is looked for in the scene."""
OTHER = {"halfway": "reflected", "reflected": "halfway"}
FEW = 0.005
"""Share of the pixels that are looked at as wild."""


@dataclass(frozen=True)
class Cause:
    """A likely mistake: what it is, what to do, and the share of the residual (RMS) that it would remove."""

    what: str
    removed: float


def causes(
    scene: Scene,
    problem: Problem,
    targets: Sequence[CheckedTarget],
    values: np.ndarray,
    left_of: Callable[[Scene], float | None],
) -> tuple[Cause, ...]:
    """The mistakes that would explain much of what is left over, the most likely first.

    `left_of`: the RMS (in units of the weights) that a few steps of another scene leave; None where it cannot be
    fitted.
    """
    tried = list(_of_pictures(problem, targets, values))
    if max((cause.removed for cause in tried), default=0.0) < ENOUGH:
        tried += _of_scenes(scene, problem, targets, values, left_of)
    return tuple(sorted((c for c in tried if c.removed >= WORTH), key=lambda c: -c.removed))


@dataclass(frozen=True)
class _Look:
    """The weighted rows of one target, and what it shows, (height, width, ...)."""

    jacobian: np.ndarray
    shown: np.ndarray
    weight: np.ndarray
    target: np.ndarray


def _looks(problem: Problem, targets: Sequence[CheckedTarget], values: np.ndarray) -> list[_Look]:
    found = []
    for rows, target in zip(whole_rows(problem, values), targets, strict=True):
        jacobian = problem.joined(np.moveaxis(rows.columns, 2, 0).astype(np.float64), rows.numbers)
        weight = np.asarray(rows.view.weight, np.float64)
        found.append(_Look(np.moveaxis(jacobian, 0, -1), rows.shown, weight, target.image.astype(np.float64)))
    return found


def _left(looks: Sequence[_Look], change: Callable[[np.ndarray], np.ndarray], factor: bool = False) -> float:
    """What the linear step to changed targets leaves, as a share of the targets; `factor`: where light times any
    number is allowed besides.
    """
    gram, right, square, size = 0.0, 0.0, 0.0, 0.0
    for look in looks:
        target = change(look.target)
        residual = ((look.shown - target) * look.weight).ravel()
        rows = look.jacobian.reshape(residual.size, -1)
        if factor:
            rows = np.concatenate([rows, (look.shown * look.weight).reshape(-1, 1)], axis=1)
        gram, right = gram + rows.T @ rows, right + rows.T @ residual
        square, size = square + residual @ residual, size + np.sum((target * look.weight) ** 2)
    explained = right @ normal_inverse(np.asarray(gram), 1e-9) @ right
    return float(np.sqrt(max(square - explained, 0.0) / max(size, 1e-300)))


def _of_pictures(problem: Problem, targets: Sequence[CheckedTarget], values: np.ndarray) -> Iterator[Cause]:
    looks = _looks(problem, targets, values)
    now = _left(looks, lambda t: t)
    if not now > 0:
        return

    def cause(what: str, change: Callable[[np.ndarray], np.ndarray], factor: bool = False) -> Cause:
        return Cause(what, 1 - _left(looks, change, factor) / now)

    yield cause(
        "the picture was read as linear but holds sRGB codes (--encoding srgb)", lambda t: decode_signal(t, "srgb")
    )
    yield cause("the picture was read as sRGB but is linear (--encoding linear)", lambda t: encode_signal(t, "srgb"))
    yield cause("the picture is upside down", lambda t: t[::-1])
    yield cause("the picture is mirrored left to right", lambda t: t[:, ::-1])
    for by, axis, where in ((1, 0, "down"), (-1, 0, "up"), (1, 1, "to the right"), (-1, 1, "to the left")):
        yield cause(
            f"the picture is shifted by a pixel {where}", lambda t, by=by, axis=axis: np.roll(t, -by, axis=axis)
        )
    yield cause(
        "the exposure of the picture is another (free shot.NAME.exposure, with one material or light known)",
        lambda t: t,
        factor=True,
    )
    yield _wild(looks, now)


def _wild(looks: Sequence[_Look], now: float) -> Cause:
    """A few pixels that are far off."""
    size = [np.sum(((look.shown - look.target) * look.weight) ** 2, axis=-1) for look in looks]
    limit = np.quantile(np.concatenate([s.ravel() for s in size]), 1 - FEW)
    masked = [
        replace(look, jacobian=look.jacobian * keep[..., None, None], weight=look.weight * keep[..., None])
        for look, s in zip(looks, size, strict=True)
        for keep in [(s <= limit).astype(float)]
    ]
    worst = max(range(len(size)), key=lambda k: size[k].max())
    row, column = np.unravel_index(np.argmax(size[worst]), size[worst].shape)
    what = f"a few wild pixels, the worst in row {row}, column {column} (mask them, or --loss cauchy)"
    return Cause(what, 1 - _left(masked, lambda t: t) / now)


def _of_scenes(scene: Scene, problem, targets, values, left_of) -> Iterator[Cause]:
    """The other highlight of the materials that are free, and the other kind of shadows."""
    now = left_of(scene)
    if not now:
        return
    free = {u.parameter.owner for u in problem.unknowns if u.parameter.family == "material"}
    lit = [name for name in free if scene.materials[name].highlight in OTHER]
    if lit and scene.lights and any(u.row.name in ("k_h", "k_s", "phong_exponent") for u in problem.unknowns):
        kinds = {OTHER[scene.materials[name].highlight] for name in lit}
        materials = {
            name: changed(m, highlight=OTHER[m.highlight]) if name in lit else m for name, m in scene.materials.items()
        }
        if (left := left_of(changed(scene, materials=materials))) is not None:
            yield Cause(f'the highlight is of the other kind (highlight = "{" or ".join(kinds)}")', 1 - left / now)
    clear = any(np.any(np.asarray(m.values["k_t"]) > 0) for m in scene.materials.values())
    if scene.lights and clear and scene.shadows in ("opaque", "tinted"):
        other = "tinted" if scene.shadows == "opaque" else "opaque"
        if (left := left_of(changed(scene, shadows=other))) is not None:
            yield Cause(f'transparent objects cast another shadow (shadows = "{other}" in [scene])', 1 - left / now)
