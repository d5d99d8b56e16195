"""From pictures to materials: fit coefficients of a scene to target images, with uncertainties."""

from ._errors import FitError
from ._fit import fit
from ._result import FitResult, FitStep, FittedCoefficient, FitView
from ._target import Target

__all__ = ["FitError", "FitResult", "FitStep", "FitView", "FittedCoefficient", "Target", "fit"]
