"""What planned pictures say of the unknowns, at the values of the scene."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from diffwhitted.image import gathered
from diffwhitted.scene import Scene

from ..problem._problem import Problem, factorise
from ..problem._rows import record_part
from ..problem._target import CheckedTarget, residual_count
from ..problem._views import Part, some_passes
from ..problem._weighing import first_weighing, weighed


@dataclass(frozen=True)
class Pictures:
    """Some of the pictures that are planned, and what they depend on."""

    problem: Problem
    targets: tuple[CheckedTarget, ...]
    values: np.ndarray
    """Of the unknowns that they may tell of."""
    columns: np.ndarray
    """The numbers of these among all."""
    count: int
    """All unknowns."""

    def factor(self) -> tuple[np.ndarray, tuple[CheckedTarget, ...]]:
        """R of the Jacobian in units of the noise, (rows, count), and the targets with what they would show. Noise of
        light is that of this light.
        """
        factor, films = factorise(self.problem, self.values)
        shown = tuple(
            replace(t, image=np.asarray(gathered(film, *t.image.shape[:2]), np.float64))
            for t, film in zip(self.targets, films, strict=True)
        )
        if self._is_lit_noise():
            weighing = first_weighing(shown, float(residual_count(self.targets)))
            factor = factorise(weighed(self.problem, shown, weighing), self.values)[0]
        return self._spread(factor), shown

    def glance(self) -> np.ndarray:
        """The same factor alone, also of pictures of which only a share of the pixels was traced."""
        return self.factor()[0] if self._is_lit_noise() else self._spread(factorise(self.problem, self.values)[0])

    def retraced(self, scene: Scene, few: bool = False) -> Pictures:
        """The pictures of another scene of the same kind, as programs know it; no other program is needed unless the
        trees need more room. `few`: a share of the pixels, for a glance, where the noise does not depend on the light.
        Where rays move, they are traced anew at each look, and nothing is to be done.
        """
        problem = replace(self.problem, scene=scene)
        if few and not self._is_lit_noise():
            problem = replace(problem, views=tuple(some_passes(view, 1) for view in problem.views))
        if problem.moves:
            return replace(self, problem=problem)
        asked = problem.asked(self.values)

        def traced(part: Part) -> Part:
            while True:
                trees = record_part(asked.scene, asked.unknowns, asked.values, replace(part, trees=None))
                needed = int(trees.descendants.max())
                if needed <= part.plan.capacity:
                    return replace(part, trees=trees)
                part = replace(part, plan=part.plan.with_capacity(2 * needed))

        views = tuple(replace(view, parts=tuple(map(traced, view.parts))) for view in problem.views)
        return replace(self, problem=replace(problem, views=views))

    def _is_lit_noise(self) -> bool:
        return any(t.noise is not None and t.noise.gain > 0 for t in self.targets)

    def _spread(self, factor: np.ndarray) -> np.ndarray:
        """From the factor [R q] of the residuals, divided by the root of their number, R in the columns of all."""
        whole = np.zeros((self.count, self.count))
        own = factor[:-1, :-1] * np.sqrt(float(residual_count(self.targets)))
        whole[: len(own), self.columns] = own
        return whole


def together(*factors: np.ndarray) -> np.ndarray:
    """The factor of several pictures from that of each."""
    return np.asarray(np.linalg.qr(np.concatenate(factors), mode="r"))
