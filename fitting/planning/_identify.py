"""What a fit would know, with no picture yet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from diffwhitted.records import changed
from diffwhitted.scene import Parameter, Scene, depth_number, whole_number

from .._errors import FitError
from .._fit import able, near_the_first, require_no_places, require_values
from .._result import FittedCoefficient
from ..judging._identifiability import Uncertainty, uncertainty
from ..judging._rest import jacobian_precision, on_bound
from ..problem._build import build
from ..problem._free_names import free_parameters, split_free
from ..problem._problem import any_moves
from ..problem._target import CheckedTarget
from ..problem._ties import tied
from ..problem._unknowns import Unknown, list_unknowns, start_values
from ..problem._weighing import first_weighing
from ._identification import Identification
from ._looking import Pictures
from ._pictures import planned

RESOLVED = 4.0
"""No standard error is below so many units in the last place of the coefficient."""


@dataclass(frozen=True)
class Question:
    """What is asked of planned pictures: which unknowns, and how pixels are sampled."""

    scene: Scene
    targets: tuple[CheckedTarget, ...]
    names: tuple[str, ...]
    unknowns: tuple[Unknown, ...]
    values: np.ndarray
    samples: int
    max_depth: int | None
    footprint: int
    notes: tuple[str, ...]

    def about(self, scene: Scene, targets: tuple[CheckedTarget, ...]) -> Pictures:
        """Some pictures of a scene. The problem of a fit of them knows nothing of the numbers of other shots."""
        shots = {t.name for t in targets}

        def told(parameter: Parameter) -> bool:
            return parameter.family != "shot" or parameter.owner in shots

        columns = np.flatnonzero([told(u.parameter) for u in self.unknowns])
        names = tuple(name for name in self.names if told(split_free(self.scene, name)[0]))
        unknowns, values = tuple(self.unknowns[k] for k in columns), self.values[columns]
        scene = changed(scene, shots=tuple(t.shot for t in targets))
        problem = build(
            scene, targets, names, tied(unknowns, None), values, self.samples, self.max_depth, self.footprint
        )[0]
        return Pictures(problem, targets, values, columns, len(self.unknowns))

    def known(self, factor: np.ndarray) -> Uncertainty:
        """What a factor in units of the noise says."""
        eps = float(jnp.finfo(self.scene.dtype).eps)
        return uncertainty(factor, 1.0, self.values, self.unknowns, jacobian_precision(self.scene), RESOLVED * eps)


def identify(
    scene: Scene,
    free: Sequence[str],
    *,
    noise=None,
    cameras: str | Sequence[str] | None = None,
    only: str | Sequence[str] = (),
    bounds: Mapping[str, tuple[float, float]] | None = None,
    samples: int = 1,
    max_depth: int | None = None,
    footprint: int | None = None,
) -> Identification:
    """What a fit would know of the free numbers if they are what the scene says: standard errors, intervals,
    correlations, and what cannot be told apart. No picture is needed.

    - `free`, `bounds`, `samples`, `max_depth`, `footprint`: as in `fit`.
    - `noise`: standard deviation of the pixels' values in linear RGB, independent in each channel; (read, gain) for
      variance = read^2 + gain * value; a mapping from names of shots or cameras to either; None: that of the shots.
    - `cameras`: whose pictures are planned, by name; None: "main", or the only one. A scene with shots is asked for all
      of its shots, and for no cameras.
    - `only`: objects; pixels that see another one do not count (see `only`).

    With the Jacobian J of all pixels, each divided by its noise, at the values of the scene, the covariance of the
    estimate is (J'J)^-1 as far as J is linear within it: so it is for small noise. How far the trees of a moving edge
    leave something out of a pixel is not in it. Raises `FitError` for input that cannot be used.
    """
    asked = question(scene, free, noise, cameras, only, bounds, samples, max_depth, footprint)
    factor, shown = asked.about(asked.scene, asked.targets).factor()
    return identification(asked, shown, asked.known(factor))


def question(scene, free, noise, cameras, only, bounds, samples, max_depth, footprint) -> Question:
    """What is asked, checked."""
    require_values(scene, bounds)
    samples, max_depth = whole_number(samples, "samples", error=FitError), depth_number(max_depth)
    targets = planned(scene, noise, cameras, only)
    placed = near_the_first(changed(scene, shots=tuple(target.shot for target in targets)), targets)
    names, passed_over = free_parameters(placed, free, max_depth, {target.camera for target in targets})
    unknowns = list_unknowns(placed, names, bounds)
    if scene.keeps_digits:
        require_no_places(unknowns)
    if footprint is None:
        footprint = placed.footprint or (samples if any_moves(unknowns) else 0)
    footprint, samples = able(placed, unknowns, footprint, samples)
    notes = tuple(f"{name} left as it is: {why}" for name, why in passed_over)
    values = start_values(placed, unknowns)
    return Question(placed, targets, names, unknowns, values, samples, max_depth, footprint, notes)


def identification(asked: Question, shown: tuple[CheckedTarget, ...], known: Uncertainty) -> Identification:
    """The answer. `shown`: the pictures that are planned, with what they would show."""
    weighing = first_weighing(shown, 1.0)
    return Identification(
        tuple(_coefficient(asked, known, number) for number in range(len(asked.unknowns))),
        known.correlation,
        known.rank,
        tuple(t.name for t in shown),
        sum(int((t.mask > 0).sum()) for t in shown),
        weighing.typical(shown),
        asked.notes,
    )


def _coefficient(asked: Question, known: Uncertainty, i: int) -> FittedCoefficient:
    unknown, value, sure = asked.unknowns[i], float(asked.values[i]), bool(known.identifiable[i])
    return FittedCoefficient(
        name=unknown.name,
        symbol=unknown.row.symbol,
        value=value,
        start=value,
        standard_error=float(known.standard_error[i]) if sure else None,
        interval_95=(float(known.interval[i][0]), float(known.interval[i][1])) if sure else None,
        identifiable=sure,
        seen=bool(known.seen[i]),
        confounded_with=tuple(asked.unknowns[j].name for j in known.confounded[i]),
        at_bound=bool(on_bound(asked.values, asked.unknowns)[i]),
        bounds=unknown.bounds,
        unit=unknown.unit,
        moves=unknown.row.moves,
    )
